"""A number of a recorded topic over the whole time, reduced to an outline of fixed size."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import numpy as np

from goalwire.apps.console.state.recording import Decoders, Recording
from goalwire.apps.console.state.series import number_at
from goalwire.errors import BagError, peer_text
from goalwire.rosbag2.reader import Reader

SPANS = 1000
_TELL_EACH = 20_000
"""The number of messages after which the points read so far are shown."""


class Outline:
    """The least and the greatest value in each of `SPANS` spans of equal length."""

    def __init__(self, start: float, end: float) -> None:
        self.count = 0
        self._start = start
        self._width = max((end - start) / SPANS, 1e-9)
        self._times = np.full((SPANS, 2), math.nan)
        self._values = np.full((SPANS, 2), math.nan)

    def add(self, time: float, value: float) -> None:
        """Add a value; values that are not finite are counted but not shown."""
        self.count += 1
        if not math.isfinite(value):
            return
        at = min(max(int((time - self._start) / self._width), 0), SPANS - 1)
        values, times = self._values[at], self._times[at]
        if not values[0] <= value:  # also True if values[0] is NaN
            values[0], times[0] = value, time
        if not values[1] >= value:
            values[1], times[1] = value, time

    def points(self) -> list[tuple[float, float]]:
        """Return the points to draw, in the order of time: at most two for each span."""
        points = {
            (float(time), float(value))
            for time, value in zip(self._times.flat, self._values.flat, strict=True)
            if not math.isnan(time)
        }
        return sorted(points)


class RecordedPlot:
    """Reads one number of a topic on a thread of its own, until it is closed."""

    def __init__(self, recording: Recording, topic: str, path: str, changed: Callable[[], object]) -> None:
        """`changed` is called in the loop when there is more to draw."""
        self.topic = topic
        self.path = path
        self.name = f'{topic} {path}'
        self.problem = ''
        self.points: list[tuple[float, float]] = []
        """Times in s since 1970, and values."""
        self.part = 0.0
        """The part of the messages that was read, from 0 to 1."""
        self._recording = recording
        self._changed = changed
        self._closed = Event()
        self._loop = asyncio.get_running_loop()
        pool = ThreadPoolExecutor(1, 'console-plot')
        pool.submit(self._read)
        pool.shutdown(wait=False)

    def _read(self) -> None:
        recording, total = self._recording, max(self._recording.counts[self.topic], 1)
        outline = Outline(recording.start / 1e9, recording.end / 1e9)
        decoders, read, seen = Decoders(recording.topics), number_at(self.path), 0
        try:
            with Reader(recording.path) as bag:
                for message in bag.messages([self.topic]):
                    if self._closed.is_set():
                        return
                    value = decoders.decode(message.topic, message.data)
                    number = None if value is None else read(value)
                    if number is not None:
                        outline.add(message.time / 1e9, number)
                    seen += 1
                    if not seen % _TELL_EACH:
                        self._tell(outline, seen / total)
        except (BagError, OSError) as error:
            self.problem = peer_text(error, 300)
        self.problem = self.problem or next(iter(decoders.problems.values()), '')
        self._tell(outline, 1.0)

    def _tell(self, outline: Outline, part: float) -> None:
        points = outline.points()

        def put() -> None:
            self.points, self.part = points, part
            self._changed()

        if not self._closed.is_set():
            self._loop.call_soon_threadsafe(put)

    def close(self) -> None:
        """Stop reading."""
        self._closed.set()
