"""Splits a process's output into lines."""

from __future__ import annotations

from collections.abc import Callable

LONGEST_LINE = 2**16
"""The most bytes of an unfinished line that are buffered; a longer line is passed on in pieces."""
_OF_A_TRACEBACK = ('Traceback (most recent call last):', 'Fatal Python error:', 'Exception ignored in')
_INTERRUPT = 'KeyboardInterrupt'


class Lines:
    """Passes the lines of an output stream to a function as soon as they are complete.

    If a Python program is interrupted while it starts, it prints a traceback about its own imports. After
    expect_interrupt(), such a traceback is dropped if it is the first output of the stream.
    """

    def __init__(self, tell: Callable[[str], None], *, cached: bool) -> None:
        self._tell_now = tell
        self._rest = b''
        self._cache: list[bytes] | None = [] if cached else None
        self._held: list[str] | None = None
        self.has_begun = False
        self.was_interrupted_early = False

    def expect_interrupt(self) -> None:
        """If the stream has had no line yet, hold back the lines of a traceback from now on."""
        if not self.has_begun:
            self._held = []

    def feed(self, data: bytes) -> None:
        """Take a piece of output, and pass on the lines that it completes."""
        if self._cache is not None:
            self._cache.append(data)
        *lines, self._rest = (self._rest + data).split(b'\n')
        for line in lines:
            self._tell(line.rstrip(b'\r').decode(errors='replace'))
        if len(self._rest) > LONGEST_LINE:  # a process that never ends its line must not fill the memory
            self._tell_rest()

    def flush(self) -> None:
        """Pass on an unfinished last line, and held lines if they are not a KeyboardInterrupt's traceback."""
        self._tell_rest()
        held, self._held = self._held or [], None
        if held and held[-1] == _INTERRUPT:
            self.was_interrupted_early = True
            return
        for line in held:
            self._tell_now(line)

    @property
    def text(self) -> str | None:
        """All output so far; None if the output is not kept."""
        return None if self._cache is None else b''.join(self._cache).decode(errors='replace')

    def _tell_rest(self) -> None:
        if self._rest:
            self._tell(self._rest.decode(errors='replace'))
            self._rest = b''

    def _tell(self, line: str) -> None:
        self.has_begun = True
        if self._held is None:
            self._tell_now(line)
            return
        self._held.append(line)
        if not self._held[0].startswith(_OF_A_TRACEBACK):
            held, self._held = self._held, None
            for waiting in held:
                self._tell_now(waiting)
