"""The frames of one bag: at equal distances of time, each with the latest values at that time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from itertools import count
from typing import Any

import numpy as np

from goalwire.apps.bag.exporting.colours import colours_of
from goalwire.apps.bag.exporting.numbers import Numbers, reader_of
from goalwire.apps.bag.exporting.survey import Camera, Layout, Vector
from goalwire.errors import BagError
from goalwire.files import show
from goalwire.rosbag2.model import Message
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.types import class_of, decoder_of

Frame = dict[str, np.ndarray[Any, Any]]
"""The values of all features by their names: float32 numbers, and pictures of height x width x 3 uint8."""
STALE_S = 1.0
"""A picture that is older than this many seconds is counted."""


class Episode:
    """The frames of a bag.

    The first frame has the time at which every feature has a value. The others follow at the layout's rate,
    until the last message of the layout's topics.
    """

    def __init__(self, bag: Reader, layout: Layout, start: int = 0) -> None:
        """Only messages that were recorded at `start` (in ns) or later are used. Raises BagError if a topic
        of the layout is missing, and InterfaceError.
        """
        self._bag = bag
        self._layout = layout
        self._start = start
        topics = {topic.name: topic for topic in bag.topics}
        missing = [name for name in layout.topics if name not in topics]
        if missing:
            raise BagError(f"'{show(bag.path)}' has no topic '{show(missing[0])}', which other bags have")
        self._sources: list[_Numbers | _Pictures] = []
        for vector in layout.vectors:
            topic = topics[vector.topic]
            read = reader_of(topic.type_name, class_of(topic, bag.topics))
            self._sources.append(_Numbers(vector, decoder_of(topic, bag.topics), read))
        for camera in layout.cameras:
            self._sources.append(_Pictures(camera, decoder_of(topics[camera.topic], bag.topics)))

    def frames(self) -> Iterator[Frame]:
        """Yield the frames; raises BagError if there is none, and DecodeError."""
        by_topic: dict[str, list[_Numbers | _Pictures]] = {}
        for source in self._sources:
            by_topic.setdefault(source.topic, []).append(source)
        times: Iterator[int] = iter(())
        due: int | None = None
        last = 0
        for message in self._bag.messages(by_topic.keys(), self._start):
            while due is not None and due < message.time:
                yield self._frame(due)
                due = next(times)
            for source in by_topic[message.topic]:
                source.take(message)
            last = message.time
            if due is None and all(source.is_known for source in self._sources):
                times = self._times(message.time)
                due = next(times)
        if due is None:
            unknown = next(source for source in self._sources if not source.is_known)
            raise BagError(f"'{show(self._bag.path)}' has no frame: {unknown.reason}")
        while due <= last:
            yield self._frame(due)
            due = next(times)

    def _times(self, first: int) -> Iterator[int]:
        """Yield the times of the frames, in ns. Each is rounded by itself, so that no error grows."""
        return (first + number * 1_000_000_000 // self._layout.fps for number in count())

    def _frame(self, time: int) -> Frame:
        return {source.feature: source.value(time) for source in self._sources}

    def left_out(self) -> list[str]:
        """Return a sentence for each reason why pictures are not in the frames so far."""
        return [reason for source in self._sources for reason in source.left_out()]

    def stale(self) -> list[str]:
        """Return a sentence for each camera that sent nothing for more than STALE_S before some frames."""
        return [
            f"{source.stale:,} frames have a picture of '{source.topic}' that is older than {STALE_S:g} s"
            for source in self._sources
            if source.stale
        ]


class _Numbers:
    """The latest numbers of a vector. A message may have some of them: then the others stay."""

    stale = 0

    def __init__(
        self, vector: Vector, decode: Callable[[bytes], Any], read: Callable[[Any], Numbers]
    ) -> None:
        self.feature = vector.feature
        self.topic = vector.topic
        self._names = vector.names
        self._decode = decode
        self._read = read
        self._latest: dict[str, float] = {}

    def take(self, message: Message) -> None:
        self._latest.update(self._read(self._decode(message.data)))

    @property
    def is_known(self) -> bool:
        return len(self._latest) == len(self._names)

    @property
    def reason(self) -> str:
        missing = [name for name in self._names if name not in self._latest]
        return f"'{show(self.topic)}' has no value of {', '.join(map(show, missing[:3]))}"

    def value(self, _time: int) -> np.ndarray[Any, Any]:
        return np.array([self._latest[name] for name in self._names], np.float32)

    def left_out(self) -> list[str]:
        return []


class _Pictures:
    """The latest picture of a camera. Only pictures that a frame has are unpacked."""

    def __init__(self, camera: Camera, decode: Callable[[bytes], Any]) -> None:
        self.feature = camera.feature
        self.topic = camera.topic
        self.stale = 0
        """The number of frames with a picture that is older than STALE_S."""
        self._size = camera.height, camera.width
        self._decode = decode
        self._waiting: Message | None = None
        self._pixels: np.ndarray[Any, Any] | None = None
        self._time = 0
        self._reasons: Counter[str] = Counter()

    def take(self, message: Message) -> None:
        self._waiting = message

    @property
    def is_known(self) -> bool:
        self._unpack()
        return self._pixels is not None

    @property
    def reason(self) -> str:
        return f"'{show(self.topic)}' has no picture that can be used"

    def value(self, time: int) -> np.ndarray[Any, Any]:
        self._unpack()
        assert self._pixels is not None
        self.stale += time - self._time > STALE_S * 1e9
        return self._pixels

    def _unpack(self) -> None:
        message, self._waiting = self._waiting, None
        if message is None:
            return
        picture = self._decode(message.data)
        try:
            pixels = colours_of(picture)
        except ValueError as error:
            self._reasons[str(error)] += 1
            return
        if pixels.shape[:2] != self._size:
            height, width, _ = pixels.shape
            self._reasons[f'the size is {width} x {height}, not {self._size[1]} x {self._size[0]}'] += 1
            return
        self._pixels, self._time = pixels, message.time

    def left_out(self) -> list[str]:
        return [
            f"{number:,} pictures of '{self.topic}' are left out: {reason}"
            for reason, number in self._reasons.items()
        ]
