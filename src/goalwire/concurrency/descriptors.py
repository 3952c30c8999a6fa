"""The file descriptors of this process: checks that enough are free, and finds the sockets of a C library.

A C library may end the whole process if it cannot open a socket. And its sockets stay open in executed
programs and forked children unless the library prevents it.
"""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from types import TracebackType
from typing import Self

from goalwire.concurrency.forks import reset_in_children
from goalwire.errors import TransportError

OF_A_SESSION = 32
"""How many descriptors opening a session may take: three threads of Zenoh and a router need over 20."""


def require_free(title: str, count: int = OF_A_SESSION) -> None:
    """Raise TransportError if fewer than `count` descriptors are free; `title` names their use."""
    free = _count_free(count)
    if free < count:
        raise TransportError(
            f'{title} needs {count} free descriptors, of files and sockets, and only {free} are left: close '
            f'some, or raise the limit{_limit()} (ulimit -n)'
        )


def _count_free(most: int) -> int:
    """Return how many descriptors can be opened, up to `most`."""
    opened: list[int] = []
    try:
        opened += os.pipe()
        while len(opened) < most:
            opened.append(os.dup(opened[0]))
    except OSError:
        return len(opened)
    finally:
        for each in opened:
            os.close(each)
    return len(opened)


def _limit() -> str:
    try:
        import resource
    except ImportError:  # Windows
        return ''
    return f' of {resource.getrlimit(resource.RLIMIT_NOFILE)[0]}'


class LibrarysSockets:
    """Finds the sockets that a C library opens within a `with` block.

    After the block, programs that this process executes do not inherit them. A forked child closes its
    copies, if their numbers are still those of the same sockets.
    """

    def __init__(self) -> None:
        self._before: dict[int, int] = {}
        self._opened: dict[int, int] = {}

    def __enter__(self) -> Self:
        self._before = _sockets()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._opened = dict(_sockets().items() - self._before.items())
        for descriptor in self._opened:
            with suppress(OSError):  # the descriptor was closed meanwhile
                os.set_inheritable(descriptor, False)
        reset_in_children(self)

    def reset_in_child(self) -> None:
        """In a forked child: close the child's copies, once."""
        opened, self._opened = self._opened, {}
        for descriptor, inode in opened.items():
            if _inode_of_socket(descriptor) == inode:
                os.close(descriptor)


def _sockets() -> dict[int, int]:
    """Return the sockets that a child would inherit, with their inodes; empty if that is unknown."""
    found = {}
    try:
        names = os.listdir('/dev/fd')  # noqa: PTH208 - pathlib takes 5 ms to import
    except OSError:
        return {}
    for name in names:
        descriptor = int(name)
        inode = _inode_of_socket(descriptor)
        with suppress(OSError):
            if inode is not None and os.get_inheritable(descriptor):
                found[descriptor] = inode
    return found


def _inode_of_socket(descriptor: int) -> int | None:
    """Return the inode of a socket; None if the descriptor is closed, or not a socket's."""
    try:
        status = os.fstat(descriptor)
    except OSError:
        return None
    return status.st_ino if stat.S_ISSOCK(status.st_mode) else None
