"""The pipe into which Python writes the number of each signal that comes.

`signal.set_wakeup_fd` has room for one descriptor in a process, and asyncio, uvloop, trio and programs want
it too. The pipe is a guest there, by four rules:

- Numbers are passed on to the descriptor that was installed before. If that descriptor was closed, its number
  may belong to another file by now. So device and inode are compared, and another file gets nothing.
- At the end the descriptor from before is installed again, if it is still open. If other code has installed
  its own descriptor meanwhile, that one stays.
- The pipe stays open as long as the process. So other code that has replaced the pipe may put it back later.
- A forked child has a pipe of its own under the same numbers: nothing of the child reaches its parent.
"""

from __future__ import annotations

import os
import signal
import sys
import warnings
from contextlib import suppress
from typing import Literal

Identity = tuple[int, int]
"""Device and inode: they identify the file behind a descriptor."""


def identity_of(fd: int) -> Identity | None:
    """Return the identity of the file behind `fd`, None if it is not open."""
    try:
        status = os.fstat(fd)
    except OSError:
        return None
    return status.st_dev, status.st_ino


class SignalPipe:
    """The pipe, and the descriptor that was installed before it. Only the main thread uses it, unless a
    method's docstring says otherwise.
    """

    def __init__(self) -> None:
        self._open()
        self._before: tuple[int, Identity] | None = None
        """The descriptor that numbers are passed on to."""

    def _open(self) -> None:
        self.reader, self._writer = os.pipe()
        if sys.platform != 'win32':
            os.set_blocking(self._writer, False)
        self._identity = identity_of(self._writer)

    def take(self) -> None:
        """Install the pipe as the process's wake-up descriptor."""
        if not self._is_intact():
            self._open()  # the program has closed all descriptors, as daemons do
        # trio warns if it finds another descriptor installed. By the rules above trio works all the same.
        warnings.filterwarnings('ignore', "It looks like Trio's signal handling", RuntimeWarning)
        before = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
        if before != self._writer:
            self._note(before)

    def take_if_free(self) -> bool:
        """Install the pipe if no descriptor is installed; False if another one is. Two system calls."""
        try:
            owner = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
        except (OSError, ValueError):
            return False  # the program has closed the pipe
        if owner == self._writer:
            return True
        if owner == -1:
            self._before = None  # other code has replaced the pipe and then removed its own descriptor
            return True
        return not _restore(owner)

    def give_back(self) -> bool:
        """Install the earlier descriptor again; False if numbers must still be passed on.

        They must if other code has replaced the pipe: that code may put the pipe back when it ends.
        """
        if not self._is_intact():
            return True
        owner = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
        before = self._before
        if owner != self._writer:
            if owner == -1 or not _restore(owner):
                signal.set_wakeup_fd(-1)
            elif before is not None and before[0] != owner:
                return False
            return True
        self._before = None
        if before is None or identity_of(before[0]) != before[1] or not _restore(before[0]):
            signal.set_wakeup_fd(-1)
        return True

    def write(self, number: int) -> bool:
        """Write a number as Python does; False if the pipe is no longer open."""
        if not self._is_intact():
            return False
        os.write(self._writer, bytes([number]))
        return True

    def pass_on(self, numbers: bytes) -> None:
        """Write signals' numbers into the earlier descriptor. Callable from any thread that has SIGPIPE
        blocked.
        """
        before = self._before
        if before is None:
            return
        try:
            own = os.dup(before[0])  # nobody can close the copy between the look and the write
        except OSError:
            return
        try:
            if identity_of(own) == before[1]:
                with suppress(OSError):  # the pipe is full, and its owner awake; or nobody reads it
                    os.write(own, numbers)
        finally:
            os.close(own)

    def renew_in_child(self) -> None:
        """In a forked child, put a new pipe in the place of the parent's pipe."""
        if not self._is_intact():
            return
        try:
            reader, writer = os.pipe()
        except OSError:  # too many files are open: `take` opens a pipe when it is needed
            os.close(self.reader)
            os.close(self._writer)
            return
        for new, old in ((reader, self.reader), (writer, self._writer)):
            os.dup2(new, old, inheritable=False)
            os.close(new)
        os.set_blocking(self._writer, False)
        self._identity = identity_of(self._writer)

    def _is_intact(self) -> bool:
        return self._identity == identity_of(self.reader) == identity_of(self._writer)

    def _note(self, before: int) -> None:
        identity = identity_of(before)
        self._before = None if identity is None else (before, identity)


def _restore(owner: int) -> bool:
    """Make `owner` the wake-up descriptor again; False if it is not open, and nothing was changed."""
    try:
        signal.set_wakeup_fd(owner, warn_on_full_buffer=False)
    except (OSError, ValueError):
        return False
    return True


Reader = Literal['listener', 'loop']
"""The reader of a pipe: the thread of the signal handlers, or the asyncio loop of the main thread.

Each reader has a pipe of its own. Else one of them would take numbers from the other.
"""

_pipes: dict[Reader, SignalPipe] = {}


def signal_pipe(reader: Reader = 'listener') -> SignalPipe:
    """Return the pipe of a reader in this process, which the first call opens."""
    pipe = _pipes.get(reader)
    if pipe is None:
        pipe = _pipes[reader] = SignalPipe()
    return pipe


def is_pipe_open() -> bool:
    """Tell whether this process has opened a pipe."""
    return bool(_pipes)


def _renew_in_child() -> None:
    for pipe in _pipes.values():
        pipe.renew_in_child()


if sys.platform != 'win32':
    os.register_at_fork(after_in_child=_renew_in_child)
