"""The descriptors of this process: whether enough are free, and which sockets a library of C's has opened.

A library of C's may end the whole process if it cannot open a socket. And its sockets stay open in programs
that this process executes and in children that it forks, if the library does not see to that.
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
"""Descriptors that opening a session may take: with three threads of Zenoh's and a router 20 are too few."""


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
    """The sockets that are opened in the block, all of them a library's.

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
        """In a forked child: close its copies, once."""
        opened, self._opened = self._opened, {}
        for descriptor, inode in opened.items():
            if _inode_of_socket(descriptor) == inode:
                os.close(descriptor)


def _sockets() -> dict[int, int]:
    """Return this process's sockets that a child inherits, with their inodes; none if that is unknown."""
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
    """Return the inode of a socket; None if the descriptor is another thing's, or closed."""
    try:
        status = os.fstat(descriptor)
    except OSError:
        return None
    return status.st_ino if stat.S_ISSOCK(status.st_mode) else None
