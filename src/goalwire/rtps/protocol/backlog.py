"""Samples of one writer that a reader keeps because they are early or incomplete."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.fragments import Partial
from goalwire.rtps.protocol.messages import DataFrag
from goalwire.rtps.protocol.parameters import read_related_sample
from goalwire.rtps.protocol.primitives import SampleIdentity
from goalwire.rtps.protocol.wire import Timer, Wire


class Sample(NamedTuple):
    """A sample in the form in which a reader delivers it."""

    writer: bytes
    """The GUID of its writer."""
    number: int
    time: int | None
    """The source timestamp by the writer's clock, in nanoseconds since 1970; None without INFO_TS."""
    payload: bytes | bytearray | None
    """The encapsulated payload; None if the sample says that an instance was disposed of or unregistered."""
    qos: bytes = b''
    """Inline QoS."""
    is_key: bool = False

    @property
    def related(self) -> SampleIdentity | None:
        """The request that this sample replies to, or the sample identity to which a reply must refer."""
        return read_related_sample(self.qos) if self.qos else None


class Backlog:
    """The samples of one writer that one reader keeps.

    All readers of a participant share one limit in bytes.
    """

    __slots__ = ('_timer', '_wire', 'held', 'partials', 'size')

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self.held: dict[int, Sample | None] = {}
        """Samples that came too early, by number; None for a number that will not come."""
        self.partials: dict[int, Partial] = {}
        """Samples with missing fragments."""
        self.size = 0
        """Bytes of the samples in `held`."""
        self._timer: Timer | None = None
        """The timer that drops unfinished samples without new fragments."""

    def _has_room(self, size: int) -> bool:
        """Return True if `size` more bytes may be kept; if not, count the refusal."""
        if self._wire.kept + size <= bounds.KEPT_SIZE:
            return True
        self._wire.refuse('sample that waits for others', f'{self._wire.kept >> 20} MiB are kept')
        return False

    # ---- whole samples

    def hold(self, sample: Sample, next_number: int) -> bool:
        """Keep an early sample and return True; beyond the bounds return False: it will be requested again.

        `next_number` is the number of the next sample to deliver, 0 if that is unknown.
        """
        number, size = sample.number, len(sample.payload or b'')
        is_near = number < next_number + bounds.AHEAD if next_number else len(self.held) < bounds.AHEAD
        if not is_near or self.size + size > bounds.AHEAD_SIZE:
            self._wire.refuse('sample too far ahead', f'{len(self.held)} wait, and number {number} came')
            return False
        if not self._has_room(size):
            return False
        self.held[number] = sample
        self.size += size
        self._wire.kept += size
        self.drop_partial(number)
        return True

    def take(self, number: int) -> Sample | None:
        """Remove a held sample and return it."""
        sample = self.held.pop(number)
        if sample is not None:
            size = len(sample.payload or b'')
            self.size -= size
            self._wire.kept -= size
        return sample

    def forget(self, number: int) -> None:
        """Note that the sample `number` will not come, unless it is held already."""
        self.held.setdefault(number, None)
        self.drop_partial(number)

    # ---- samples in fragments

    def add(self, fragment: DataFrag, next_number: int, *, is_reliable: bool) -> Partial | None:
        """Keep some fragments, and return their sample, complete or not; None if the bounds are exceeded.

        Raises RtpsError for fragments that do not fit together.
        """
        number, partials = fragment.number, self.partials
        begun = partials.get(number)
        if begun is None:
            begun = Partial(fragment)
            if next_number and number >= next_number + bounds.MOST_UNFINISHED and is_reliable:
                # Not counted as refused: on a lossy network this is normal. The sample is requested again.
                return None
            while len(partials) >= bounds.MOST_UNFINISHED:
                self._wire.refuse('unfinished sample', f'{bounds.MOST_UNFINISHED} newer ones are unfinished')
                self.drop_partial(next(iter(partials)))
            partials[number] = begun
        if not self._has_room(len(fragment.payload)):
            self.drop_partials(lambda _: True)
            return None
        before = begun.kept
        begun.heard = self._wire.clock()
        if self._timer is None:
            self._timer = self._wire.timers.at(begun.heard + bounds.UNFINISHED_S, self._drop_stale)
        begun.add(fragment)
        self._wire.kept += begun.kept - before
        return begun

    def drop_partial(self, number: int) -> None:
        """Drop the unfinished sample with this number, if it is kept."""
        begun = self.partials.pop(number, None)
        if begun is not None:
            self._wire.kept -= begun.kept

    def drop_partials(self, is_dropped: Callable[[int], bool]) -> None:
        """Drop the unfinished samples whose number `is_dropped` selects."""
        for number in [number for number in self.partials if is_dropped(number)]:
            self.drop_partial(number)

    def _drop_stale(self) -> None:
        """Drop unfinished samples that got no new fragment for UNFINISHED_S, and set the timer again."""
        self._timer = None
        now, kept_s = self._wire.clock(), bounds.UNFINISHED_S
        for number in [number for number, begun in self.partials.items() if begun.heard + kept_s <= now]:
            self._wire.refuse('unfinished sample', f'nothing more of it came for {kept_s:g} s')
            self.drop_partial(number)
        if self.partials:
            oldest = min(begun.heard for begun in self.partials.values())
            self._timer = self._wire.timers.at(oldest + kept_s, self._drop_stale)

    # ---- both

    def drop_below(self, first: int) -> None:
        """Drop all kept samples whose number is below `first`."""
        for number in [number for number in self.held if number < first]:
            self.take(number)
        self.drop_partials(lambda number: number < first)

    def clear(self) -> None:
        """Drop all samples."""
        for number in list(self.held):
            self.take(number)
        self.drop_partials(lambda _: True)
        if self._timer is not None:
            self._timer.cancel()
