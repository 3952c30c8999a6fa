"""A child of matrix.py: it looks at the files that it has, reports by a named pipe, and ends as it was told.

It imports nothing of ROS. As a program of its own: child.py PIPE END.
"""

from __future__ import annotations

import os
import signal
import stat
import sys
import tempfile
from collections.abc import Callable, Mapping

ENDS: dict[str, int] = {
    'return': 0,
    'sys.exit': 3,
    '_exit': 4,
    'exception': 1,
    'SIGTERM': -signal.SIGTERM,
    'SIGKILL': -signal.SIGKILL,
}
"""The ways to end, and the exit code of each; negative: the signal."""


def open_files(number: int) -> dict[int, bytes]:
    """Open so many files; return what is in each, by descriptor."""
    files = {}
    for index in range(number):
        descriptor, path = tempfile.mkstemp()
        os.unlink(path)  # noqa: PTH108 - pathlib takes 5 ms to import
        files[descriptor] = f'{os.getpid()} {index}'.encode()
        os.write(descriptor, files[descriptor])
    return files


def complaints(files: Mapping[int, bytes]) -> list[str]:
    """Say which of the files are not what they were."""
    found = []
    for descriptor, text in files.items():
        try:
            read = os.pread(descriptor, 64, 0)
        except OSError as error:
            read = str(error).encode()
        if read != text:
            found.append(f'file {descriptor} is {read!r} and not {text!r}')
    return found


def network_sockets() -> list[int]:
    """Return this process's descriptors that are sockets of the network, and that others may reach.

    Left out are those without a port, and those connected to port 9: they ask the system for the addresses
    of this machine, and are closed at once.
    """
    import socket

    def is_reachable(sock: socket.socket) -> bool:
        if sock.family not in {socket.AF_INET, socket.AF_INET6}:
            return False
        try:
            return bool(sock.getsockname()[1]) and sock.getpeername()[1] != 9
        except OSError:  # it has no peer
            return bool(sock.getsockname()[1])

    found = []
    for name in os.listdir('/proc/self/fd'):  # noqa: PTH208
        try:
            if not stat.S_ISSOCK(os.fstat(int(name)).st_mode):
                continue
        except OSError:
            continue  # that of the listing
        looked_at = socket.socket(fileno=int(name))
        if is_reachable(looked_at):
            found.append(int(name))
        looked_at.detach()
    return found


def report(pipe: str, texts: list[str]) -> None:
    """Tell the process id, and what is wrong."""
    with open(pipe, 'w', encoding='utf-8') as file:  # noqa: PTH123
        file.write('\n'.join([str(os.getpid()), *texts, 'end']))


def live(pipe: str, end: str, look: Callable[[], list[str]] = list) -> None:
    """Look at what there is, report it, and end; returns where that is the way to end."""
    own = open_files(8)
    found = look()
    report(pipe, [*found, *complaints(own)])
    if end == 'sys.exit':
        sys.exit(ENDS[end])
    if end == '_exit':
        os._exit(ENDS[end])
    if end == 'exception':
        raise ValueError('as it was told')
    while end.startswith('SIG'):
        signal.pause()


if __name__ == '__main__':
    live(sys.argv[1], sys.argv[2])
