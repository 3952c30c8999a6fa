"""What a test left behind: threads and file descriptors."""

from __future__ import annotations

import gc
import sys
import threading
from pathlib import Path

from helpers.patience import PATIENCE


def live_threads() -> set[threading.Thread]:
    """Return the threads that Python code started; those a library lent us for a callback are not ours."""
    # isinstance of a private class: threading has no public word for "not started by Python".
    return {thread for thread in threading.enumerate() if not isinstance(thread, threading._DummyThread)}


def open_descriptors() -> set[str]:
    """Return what this process holds open: files, pipes and network sockets (empty where unknown).

    Kernel objects without a name and UNIX sockets are left out: a runtime below Python makes some of them
    once per process and keeps them.
    """
    if sys.platform != 'linux':
        return set()
    sockets, found = {}, set()
    for descriptor in Path('/proc/self/fd').iterdir():
        try:
            target = str(descriptor.readlink())
        except FileNotFoundError:
            continue  # the descriptor of the listing itself
        if target.startswith('socket:'):
            sockets[target[len('socket:[') : -1]] = f'{descriptor.name} -> {target}'
        elif not target.startswith('anon_inode:'):
            found.add(f'{descriptor.name} -> {target}')
    if sockets:  # the tables are long on a busy machine, and most tests have no socket
        found.update(sockets[inode] for inode in _network_inodes() & sockets.keys())
    return found


def _network_inodes() -> set[str]:
    return {
        line.split()[9]
        for table in ('tcp', 'tcp6', 'udp', 'udp6')
        if (path := Path(f'/proc/self/net/{table}')).exists()
        for line in path.read_text().splitlines()[1:]
    }


class Inventory:
    """Threads and descriptors at one moment, and what has been added since."""

    def __init__(self) -> None:
        self._threads = live_threads()
        self._descriptors = open_descriptors()

    def added_threads(self) -> list[str]:
        """Wait for threads on their way out; return the names of those that stay."""
        new = live_threads() - self._threads
        for thread in new:
            thread.join(PATIENCE)
        return sorted(thread.name for thread in new if thread.is_alive())

    def added_descriptors(self) -> list[str]:
        """Return the descriptors opened since, garbage aside."""
        new = open_descriptors() - self._descriptors
        if new:
            gc.collect()
            new &= open_descriptors()
        return sorted(new)
