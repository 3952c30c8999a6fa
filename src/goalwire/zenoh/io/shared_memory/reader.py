"""The reader's side of one link: payloads are copied out of the writer's segments, or viewed in place.

The content of another process's segment may be nonsense, and may change at any time. So a header is copied
into memory of our own, and its values are checked against the sizes of the segments. After the payload is
copied, the header is read again: an equal generation means that the chunk was not reused meanwhile.

A writer of goalwire's lends each header to one link only, and waits until it is given back. Its chunks may be
viewed in place. Chunks of any other writer are copied at once, since it may take them back by time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from mmap import ACCESS_READ, ALLOCATIONGRANULARITY, mmap
from typing import TYPE_CHECKING, TypeAlias
from weakref import finalize

from goalwire.freed_memory import LARGE, keep_freed_memory
from goalwire.weak_members import WeakMembers
from goalwire.zenoh.io.shared_memory import layout
from goalwire.zenoh.io.shared_memory.agreement import OwnAuth, Partner
from goalwire.zenoh.io.shared_memory.segments import ForeignSegment
from goalwire.zenoh.protocol.primitives import ZenohProtocolError
from goalwire.zenoh.protocol.shared_memory import Pointer, Slices

if TYPE_CHECKING:
    from atomicshm import AtomicView

MOST_SEGMENTS = 64
"""Segments that one link keeps open. A further segment closes the one that was opened first."""
MOST_VIEWS = 64
"""Views of chunks that one link keeps at a time, each with a mapping. Further payloads are copied."""
_HEADER = layout.HEADER
_COUNT = _HEADER.size // 4


MakeAtomic: TypeAlias = 'Callable[[mmap], AtomicView]'


def find_atomics() -> MakeAtomic | None:
    """Return the class that does atomic operations on a mapping; None if its package is not installed.

    Only pointers of writers other than goalwire's need it: there several processes count in one header.
    """
    try:
        from atomicshm import AtomicView
    except ImportError:
        return None
    return AtomicView


class Metadata:
    """A metadata segment of a writer."""

    def __init__(self, number: int, partner: Partner) -> None:
        """Open segment `number`. Raises OSError or ValueError."""
        self.file = ForeignSegment(number, writable=True)
        if self.file.size != layout.METADATA_SIZE:
            self.file.close()
            raise ValueError(f'metadata segment {number} has {self.file.size} bytes')
        self.map = self.file.map
        self.counts = memoryview(self.map).cast('I')
        magic, owner = layout.OWNER.unpack_from(self.map, layout.OWNER_AT)
        self.is_ours_alone = partner.is_goalwire and (magic, owner) == (layout.MAGIC, partner.number)
        """True if each header is lent to this link only, and the writer waits until it is given back."""
        self.has_views = False
        """True if views of chunks were made; they may still be alive."""
        self._atomic: AtomicView | None = None

    def atomic(self, make: MakeAtomic) -> AtomicView:
        """Return the segment as the target of atomic operations."""
        if self._atomic is None:
            self._atomic = make(self.map)
        return self._atomic

    def lower(self, index: int) -> None:
        """Give back a header that was lent to this link only."""
        self.counts[index * _COUNT] = 0

    def close(self) -> None:
        """Close the segment. Views that are alive can still give their headers back."""
        if self._atomic is not None:
            self._atomic.close()
        if not self.has_views:
            self.counts.release()
        self.file.close()


class MemoryReader:
    """Reads the payloads of pointers that came over one link, on the thread that reads the link."""

    def __init__(
        self,
        partner: Partner,
        counters: Sequence[int],
        own: OwnAuth | None,
        make_atomic: MakeAtomic | None,
        is_forked: Callable[[], bool],
        largest: int,
        note_odd: Callable[[Partner], None],
    ) -> None:
        """`counters` are what the other side has lent; `largest` is the size of a message in bytes.

        Views keep `own` alive, and so locked. `note_odd` is called for an invalid pointer or header.
        """
        self._partner = partner
        self._own = own
        self._make_atomic = make_atomic
        self._counters = counters
        self._lent_counters: AtomicView | None = None
        if make_atomic is not None and counters:
            self._lent_counters = make_atomic(partner.segment.map)
        self._is_forked = is_forked
        self._largest = largest
        self._note_odd = note_odd
        self._metadata: dict[int, Metadata] = {}
        self._data: dict[int, ForeignSegment] = {}
        self._views: WeakMembers[mmap] = WeakMembers()

    def take(self, slices: Slices, priority: int, *, as_view: bool) -> bytes | memoryview | None:
        """Return the payload; None if its sender has reused a chunk. Raises ZenohProtocolError."""
        try:
            return self._take(slices, priority, as_view=as_view)
        except ZenohProtocolError:
            self._note_odd(self._partner)
            raise

    def _take(self, slices: Slices, priority: int, *, as_view: bool) -> bytes | memoryview | None:
        """Join the slices. Pointers are followed even after a lost slice, to give all headers back."""
        size = sum(each.size if isinstance(each, Pointer) else len(each) for each in slices)
        if size > self._largest:
            raise ZenohProtocolError(f'a message in shared memory has more than {self._largest} bytes')
        if size >= LARGE and not as_view:
            keep_freed_memory()
        as_view = as_view and len(slices) == 1
        parts: list[bytes | memoryview] = []
        is_lost = False
        for each in slices:
            part = self._follow(each, priority, as_view=as_view) if isinstance(each, Pointer) else each
            if part is None:
                is_lost = True
            else:
                parts.append(part)
        if is_lost:
            return None
        return parts[0] if len(parts) == 1 else b''.join(parts)

    def has_views(self) -> bool:
        """True while a view of the writer's chunks is in use."""
        return bool(self._views.alive())

    def _follow(self, pointer: Pointer, priority: int, *, as_view: bool) -> bytes | memoryview | None:
        """Return the bytes that a pointer leads to, None if they are lost. Lowers a counter that was lent."""
        try:
            metadata = self._open_metadata(pointer.segment)
            if metadata.is_ours_alone:
                return self._take_own(metadata, pointer, as_view=as_view)
            if self._make_atomic is None:
                raise ZenohProtocolError('it sent a pointer, although this side cannot read pointers')
            return self._take_foreign(metadata, metadata.atomic(self._make_atomic), pointer)
        except (OSError, ValueError) as error:
            raise ZenohProtocolError(f"the sender's shared memory cannot be read: {error}") from None
        finally:
            if self._lent_counters is not None:
                self._lent_counters.fetch_sub_u32(layout.COUNTERS_AT + 4 * self._counters[priority], 1)

    def _take_own(self, metadata: Metadata, pointer: Pointer, *, as_view: bool) -> bytes | memoryview | None:
        """Read a chunk of a writer that waits until its header is given back."""
        index = pointer.header
        chunk = _check(metadata, pointer)
        if chunk is None:
            return None
        number, offset = chunk
        segment = self._open_data(number, offset + pointer.size)
        if as_view and len(self._views.alive()) < MOST_VIEWS:
            return self._view(metadata, segment, offset, pointer)
        # The header is given back only after the copy: from then on the writer may reuse the chunk.
        payload = segment.map[offset : offset + pointer.size]
        is_intact = _check(metadata, pointer) == chunk
        metadata.lower(index)
        return payload if is_intact else None

    def _view(self, metadata: Metadata, segment: ForeignSegment, offset: int, pointer: Pointer) -> memoryview:
        """Return a view that gives the header back when the last reference to the view is gone.

        The view has a mapping of its own, which lives as long as the view, even after the link has ended.
        """
        start = offset // ALLOCATIONGRANULARITY * ALLOCATIONGRANULARITY
        end = offset + pointer.size
        mapped = mmap(segment.fd, end - start, access=ACCESS_READ, offset=start)
        self._views.add(mapped)
        metadata.has_views = True
        finalize(mapped, _give_back, metadata, pointer.header, self._is_forked, self._own).atexit = False
        return memoryview(mapped)[offset - start :]

    def _take_foreign(self, metadata: Metadata, atomic: AtomicView, pointer: Pointer) -> bytes | None:
        """Copy a chunk whose writer reuses it after a timeout; setting the watchdog bit restarts it."""
        if pointer.header >= layout.HEADERS:
            raise ValueError(f'there is no header {pointer.header}: a segment has {layout.HEADERS}')
        atomic.fetch_or_u64(layout.WATCHDOGS_AT + pointer.header // 64 * 8, 1 << pointer.header % 64)
        try:
            chunk = _check(metadata, pointer)
            if chunk is None:
                return None
            number, offset = chunk
            payload = self._open_data(number, offset + pointer.size).read(pointer.size, offset)
            if len(payload) != pointer.size or _check(metadata, pointer) != chunk:
                return None
            return payload
        finally:
            atomic.fetch_sub_u32(pointer.header * _HEADER.size, 1)

    def _open_metadata(self, number: int) -> Metadata:
        """Return an open metadata segment. A new file may reuse a name, so the name is checked each time."""
        metadata = self._metadata.get(number)
        if metadata is not None and (metadata.is_ours_alone or metadata.file.is_current()):
            return metadata
        if metadata is not None:
            self._metadata.pop(number).close()
        if len(self._metadata) >= MOST_SEGMENTS:
            self._metadata.pop(next(iter(self._metadata))).close()
        metadata = self._metadata[number] = Metadata(number, self._partner)
        return metadata

    def _open_data(self, number: int, end: int) -> ForeignSegment:
        """Return a data segment that has at least `end` bytes."""
        segment = self._data.get(number)
        if segment is None:
            if len(self._data) >= MOST_SEGMENTS:
                self._data.pop(next(iter(self._data))).close()
            segment = self._data[number] = ForeignSegment(number)
        if end > segment.size:
            raise ValueError(f'a chunk ends at byte {end} of {segment.size} in segment {number}')
        return segment

    def close(self) -> None:
        """Close the open segments. Views stay valid."""
        if self._lent_counters is not None:
            self._lent_counters.close()
            self._lent_counters = None
        for metadata in self._metadata.values():
            metadata.close()
        for segment in self._data.values():
            segment.close()
        self._metadata.clear()
        self._data.clear()


def _give_back(
    metadata: Metadata, index: int, is_forked: Callable[[], bool], _locked: OwnAuth | None
) -> None:
    """Give a header back after its view has ended; not in a forked child, where it is the parent's."""
    if not is_forked():
        metadata.lower(index)


def _check(metadata: Metadata, pointer: Pointer) -> tuple[int, int] | None:
    """Return the data segment and offset that a header names; None if the chunk was reused meanwhile.

    Raises ValueError for an impossible header.
    """
    if pointer.header >= layout.HEADERS:
        raise ValueError(f'there is no header {pointer.header}: a segment has {layout.HEADERS}')
    at = pointer.header * _HEADER.size
    _, invalidated, generation, protocol, segment, offset, length = _HEADER.unpack_from(metadata.map, at)
    if invalidated or generation != pointer.generation:
        return None
    if protocol != layout.POSIX or pointer.size > length:
        raise ValueError(f'header {pointer.header} names {length} bytes of protocol {protocol}')
    return segment, offset
