"""The writer: the memory from which a session publishes, and which readers hold which part of it.

A chunk is borrowed, filled once, and lent to each link that takes it. Each loan has a header of its own with
a count of 1, which its reader lowers. So the writer never changes a header that is lent, and needs no atomic
instruction. When the pool needs room, it looks for headers with a count of 0.

Of all data in a segment, the writer trusts only the count. The places, sizes and holders of chunks stand in
tables of its own.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.freed_memory import LARGE, keep_freed_memory
from goalwire.zenoh.io.shared_memory import layout
from goalwire.zenoh.io.shared_memory.allocator import Allocator, round_up
from goalwire.zenoh.io.shared_memory.segments import ForeignSegment, OwnSegment
from goalwire.zenoh.protocol.shared_memory import Pointer

if TYPE_CHECKING:
    from goalwire.payload_parts import Parts

FIRST_SEGMENT = 4 << 20
"""Bytes of the first data segment. C++ readers lock it in memory, where 8 MiB is the usual limit."""
MOST_LENT = 4096
"""The most headers that are lent at one time, over all links."""
PROBE_SIZE = 64
PAUSE_S = 1.0
"""How long the pool does not try to grow again after a failure."""
GRACE_S = 1.0
"""How long a chunk is kept after its reader's process has ended: that process may have passed it on."""
_COUNT = layout.HEADER.size // 4


class DataSegment:
    """A data segment of the pool, and the table of its free places."""

    def __init__(self, pool: MemoryPool, size: int) -> None:
        self.file = OwnSegment(size, 32)
        self.places = Allocator(size)
        self.view = memoryview(self.file.map)
        self.probe = Chunk(pool, self, self.places.take(PROBE_SIZE) or 0, PROBE_SIZE)
        """A chunk that is lent to test whether a reader can open the segment. It is never freed."""

    def close(self) -> None:
        """Remove it."""
        with suppress(BufferError):  # raised while another thread fills a chunk
            self.view.release()
        self.file.close()


class Chunk:
    """A part of a data segment. It is free when neither the publisher nor a reader holds it."""

    __slots__ = ('_pool', '_start', 'holders', 'offset', 'room', 'segment', 'size')

    def __init__(self, pool: MemoryPool, segment: DataSegment, offset: int, size: int) -> None:
        self._pool = pool
        self.segment = segment
        self._start = self.offset = offset
        self.room = size
        """Bytes that were taken from the segment."""
        self.size = size
        self.holders = 1

    def write(self, payload: bytes | memoryview | Parts) -> bool:
        """Copy the payload into the chunk; False if the session was closed meanwhile."""
        try:
            place = self.view
        except ValueError:  # closing the session has released the view
            return False
        with place:
            if isinstance(payload, (bytes, memoryview)):
                place[:] = payload
            else:
                payload.write_to(place)
        return True

    def narrow(self, start: int, size: int) -> None:
        """Shorten the payload to `size` bytes from `start` on."""
        self.offset, self.size = self._start + start, size

    @property
    def view(self) -> memoryview:
        """The payload. Raises ValueError once the session is closed."""
        return self.segment.view[self.offset : self.offset + self.size]

    def give_back(self) -> None:
        """Return the chunk's bytes to its segment."""
        self.segment.places.give(self._start, self.room)

    def end(self) -> None:
        """Give the chunk up: the publisher does not need it any more."""
        self._pool.let_go(self)


class Lent:
    """The headers that one reader holds."""

    def __init__(self, reader: ForeignSegment) -> None:
        """`reader` is the reader's segment for the handshake; its lock shows if that process lives."""
        self.reader = reader
        self.chunks: dict[int, Chunk] = {}
        """The lent chunks by the index of their header."""
        self.size = 0
        self.given_up_at: float | None = None
        """When the link ended, or None; the reader may hold views after that."""


class MemoryPool:
    """The pool of one session. Any thread may use it; the lock is held only while the tables are changed."""

    def __init__(self, size: int, least: int, owner: int, warn: Callable[[str], None]) -> None:
        """`size` is the pool's and `least` the smallest payload's, in bytes; `owner` is the number of the
        session's segment for the handshake.
        """
        self.size = size
        self.least = least
        self.share = size // 2
        """Bytes that one reader may hold. A reader that holds nothing may get one chunk of any size."""
        self._owner = owner
        self._warn = warn
        self._section = CriticalSection()
        self._segments: list[DataSegment] = []
        self._metadata: OwnSegment | None = None
        self._counts = memoryview(b'')
        self._generations: list[int] = []
        self._free_headers: deque[int] = deque()
        self._readers: list[Lent] = []
        self._no_growth_before = 0.0
        self._is_open = True

    # ---- what publishers ask for

    def borrow(self, size: int) -> Chunk | None:
        """Return a chunk; None if the pool is full."""
        if size > self.size or self._section.is_entered():
            return None
        if size >= LARGE:
            keep_freed_memory()
        found: list[Chunk] = []
        self._section.run(partial(self._borrow, size, found))
        return found[0] if found else None

    def _borrow(self, size: int, found: list[Chunk]) -> None:
        """Find room, first in returned loans, then in chunks of ended processes, then in a new segment."""
        if not self._is_open:
            return
        self._collect()
        chunk = self._take(size)
        if chunk is None and self._collect_orphans():
            chunk = self._take(size)
        if chunk is None and self._grow(size):
            chunk = self._take(size)
        if chunk is not None:
            found.append(chunk)

    def _take(self, size: int) -> Chunk | None:
        for segment in self._segments:
            offset = segment.places.take(size)
            if offset is not None:
                return Chunk(self, segment, offset, size)
        return None

    def _grow(self, size: int) -> bool:
        """Add a segment, twice as large as the last; False if there is no room for it."""
        left = self.size - sum(each.file.size for each in self._segments)
        wanted = max(FIRST_SEGMENT << len(self._segments), 2 * round_up(size) + PROBE_SIZE)
        new = min(wanted, left, layout.MOST_CHUNK)
        now = monotonic()
        if new < round_up(size) + PROBE_SIZE or now < self._no_growth_before:
            return False
        try:
            if self._metadata is None:
                self._make_metadata()
            self._segments.append(DataSegment(self, new))
        except OSError as error:
            first = not self._no_growth_before
            self._no_growth_before = now + PAUSE_S
            if first:
                self._warn(
                    f'no shared memory of {new} bytes is available ({error.strerror or error}): '
                    'large messages go over sockets; make room in /dev/shm, or lower ZENOH_SHM_ALLOC_SIZE'
                )
            return False
        return True

    def _make_metadata(self) -> None:
        """Make the segment of headers, which goalwire's readers recognise by its owner's name in it."""
        metadata = OwnSegment(layout.METADATA_SIZE, 16)
        layout.OWNER.pack_into(metadata.map, layout.OWNER_AT, layout.MAGIC, self._owner)
        self._counts = memoryview(metadata.map).cast('I')
        self._generations = [0] * MOST_LENT
        self._free_headers = deque(range(MOST_LENT))
        self._metadata = metadata

    def let_go(self, chunk: Chunk) -> None:
        """End the caller's hold on a chunk; free it if nobody else holds it."""
        self._section.run(partial(self._drop, chunk))

    def _drop(self, chunk: Chunk) -> None:
        chunk.holders -= 1
        if not chunk.holders and self._is_open:
            chunk.give_back()

    # ---- what links ask for

    def add_reader(self, reader: ForeignSegment) -> Lent:
        """Return a new table of the chunks that a link's other side holds."""
        lent = Lent(reader)
        self._section.run(partial(self._readers.append, lent))
        return lent

    def lend(self, chunk: Chunk, lent: Lent) -> Pointer | None:
        """Lend a chunk to a reader; None if the reader has used up its share, or no header is free."""
        if self._section.is_entered():
            return None
        found: list[Pointer] = []
        self._section.run(partial(self._lend, chunk, lent, found))
        return found[0] if found else None

    def _lend(self, chunk: Chunk, lent: Lent, found: list[Pointer]) -> None:
        metadata = self._metadata
        if metadata is None or not self._is_open or lent.given_up_at is not None or not self._free_headers:
            return
        if lent.size and lent.size + chunk.size > self.share:
            return
        # Each loan has a new generation, by which a reader recognises that a header was reused.
        index = self._free_headers.popleft()
        generation = self._generations[index] = (self._generations[index] + 1) & 0xFFFFFFFF
        layout.HEADER.pack_into(
            metadata.map,
            index * layout.HEADER.size,
            1,
            0,
            generation,
            layout.POSIX,
            chunk.segment.file.number,
            chunk.offset,
            chunk.size,
        )
        chunk.holders += 1
        lent.chunks[index] = chunk
        lent.size += chunk.size
        found.append(Pointer(chunk.size, metadata.number, index, generation))

    def take_back(self, pointer: Pointer, lent: Lent) -> None:
        """Take back a loan whose pointer was not sent."""
        self._section.run(partial(self._end_loan, pointer.header, lent))

    def is_back(self, pointer: Pointer) -> bool:
        """True if the reader has lowered the count of a loan."""
        try:
            return not self._counts[pointer.header * _COUNT]
        except ValueError:  # the session was closed meanwhile
            return False

    def give_up(self, lent: Lent) -> None:
        """Take note that a reader's link has ended. The reader's chunks are kept while its process lives."""
        self._section.run(partial(self._give_up, lent))

    def _give_up(self, lent: Lent) -> None:
        if lent.given_up_at is None:
            lent.given_up_at = monotonic()
            self._collect()
            if not lent.chunks or not self._is_open:
                self._forget(lent)

    def _forget(self, lent: Lent) -> None:
        if lent in self._readers:
            self._readers.remove(lent)
        lent.reader.close()

    # ---- chunks that readers give back

    def _end_loan(self, index: int, lent: Lent) -> None:
        """Make a header free again, and end its hold on the chunk."""
        chunk = lent.chunks.pop(index, None)
        if chunk is not None and self._is_open:
            lent.size -= chunk.size
            self._free_headers.append(index)
            self._drop(chunk)

    def _collect(self) -> None:
        """End the loans that readers have given back."""
        if not self._is_open:
            return
        counts = self._counts
        for lent in list(self._readers):
            for index in [each for each in lent.chunks if not counts[each * _COUNT]]:
                self._end_loan(index, lent)
            if lent.given_up_at is not None and not lent.chunks:
                self._forget(lent)

    def _collect_orphans(self) -> bool:
        """Take back the chunks of processes that have ended; True if there were any."""
        now = monotonic()
        found = False
        for lent in list(self._readers):
            at = lent.given_up_at
            if at is None or now - at < GRACE_S or lent.reader.has_owner():
                continue
            found = True
            for index in list(lent.chunks):
                self._end_loan(index, lent)
            self._forget(lent)
        return found

    # ---- the end

    def close(self) -> None:
        """Remove the segments. Readers that have them open can still read them."""
        self._section.run(self._close)

    def _close(self) -> None:
        """Forget the readers, then remove the segments. Chunks that are still in use are not freed later."""
        self._is_open = False
        for lent in list(self._readers):
            self._forget(lent)
        for segment in self._segments:
            segment.close()
        self._segments.clear()
        self._counts.release()
        if self._metadata is not None:
            self._metadata.close()

    def abandon(self) -> None:
        """Close the descriptors only, in a forked child: the segments are the parent's."""
        for each in (*(segment.file for segment in self._segments), self._metadata):
            if each is not None:
                each.abandon()
        self._is_open = False
