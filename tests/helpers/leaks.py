"""The threads and file descriptors that a test left behind."""

from __future__ import annotations

import gc
import os
import socket
import sys
import threading
from contextlib import suppress

from helpers.patience import PATIENCE, wait_for


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
    found = set()
    # Twice a test: with paths it would take a millisecond.
    for descriptor in os.listdir('/proc/self/fd'):  # noqa: PTH208
        try:
            target = os.readlink(f'/proc/self/fd/{descriptor}')  # noqa: PTH115
        except FileNotFoundError:
            continue  # the descriptor of the listing itself
        if target.startswith('socket:'):
            if not _is_network_socket(int(descriptor)):
                continue
        elif target.startswith('anon_inode:'):
            continue
        found.add(f'{descriptor} -> {target}')
    return found


def _is_network_socket(descriptor: int) -> bool:
    # The descriptor says so itself. To read the kernel's tables of sockets takes milliseconds, twice a test.
    try:
        looked_at = socket.socket(fileno=descriptor)
    except OSError:
        return False  # closed by now
    family = looked_at.family
    looked_at.detach()
    return family in (socket.AF_INET, socket.AF_INET6)


class Inventory:
    """Threads and descriptors at one moment, and what has been added since."""

    def __init__(self) -> None:
        self._threads = live_threads()
        self._descriptors = open_descriptors()

    def added_threads(self) -> list[str]:
        """Wait for threads on their way out; return the names of those that stay."""
        new = live_threads() - self._threads
        for thread in new:
            with suppress(RuntimeError):  # it is just being started: a node's that was dropped, say
                thread.join(PATIENCE)
        return sorted(thread.name for thread in new if thread.is_alive())

    def added_descriptors(self) -> list[str]:
        """Wait for descriptors that are about to close; return those opened since that stay, garbage aside.

        A session of eclipse-zenoh closes the connections of its peers after its `close` has returned.
        """
        new = open_descriptors() - self._descriptors
        if not new:
            return []  # as after most tests, which pay for one look instead of three
        gc.collect()
        with suppress(AssertionError):
            wait_for(lambda: not new & open_descriptors())
        return sorted(new & open_descriptors())
