"""The position of a page in a recording, and the speed of playing."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic


class Playhead:
    """A time between a start and an end, in ns; it runs with a clock while it plays."""

    def __init__(self, start: int, end: int, clock: Callable[[], float] = monotonic) -> None:
        self.start = start
        self.end = end
        self.is_playing = False
        self.rate = 1.0
        self._clock = clock
        self._from = start
        self._since = clock()

    @property
    def time(self) -> int:
        """The present position; reaching the end stops playing."""
        if not self.is_playing:
            return self._from
        time = self._from + int((self._clock() - self._since) * self.rate * 1e9)
        if time >= self.end:
            self.is_playing, self._from = False, self.end
            return self.end
        return time

    def seek(self, time: int) -> None:
        """Go to a time, limited to the recording; a playhead that was playing goes on playing."""
        self._from = min(max(time, self.start), self.end)
        self._since = self._clock()

    def step(self, by: int) -> None:
        """Pause, and move by some ns; a negative number moves back."""
        self.pause()
        self.seek(self._from + by)

    def play(self) -> None:
        """Play from the present position, or from the start if this is the end."""
        self.seek(self.start if self.time >= self.end else self.time)
        self.is_playing = True

    def pause(self) -> None:
        """Stop at the present position."""
        self.seek(self.time)
        self.is_playing = False

    def set_rate(self, rate: float) -> None:
        """Play `rate` times as fast as recorded."""
        self.seek(self.time)
        self.rate = rate
