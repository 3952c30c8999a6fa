"""Payloads in shared memory: the pointers that travel in their place, and the marks of such messages.

A marked payload is a list of slices. Each slice is raw bytes, or a pointer to a chunk in a segment of the
sender's. A pointer names a header. The sender keeps a table of headers in a metadata segment, and each header
contains the place of a chunk. The receiver of a pointer reads the chunk, and then lowers the header's count.

    PUT      extension 2, without a body, mandatory; then the slices stand where the payload would
    QUERY    extension 4, without a body, directly before the body (extension 3), whose length then means
             nothing

ERR never has pointers. `goalwire.zenoh.io.shared_memory` has the layout of the segments; this module has only
the encoding on the wire. Source: eclipse-zenoh 1.9.0 and 1.10.2, commons/zenoh-codec/src/zenoh/put.rs,
query.rs, core/.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias, runtime_checkable

from goalwire.zenoh.protocol.primitives import (
    MANDATORY,
    ZenohProtocolError,
    decode_z,
    encode_data,
    encode_z,
)

if TYPE_CHECKING:
    from goalwire.payload_parts import Parts

EXTENSION_OF_INIT = 0x42
"""In INIT: the id of the sender's segment; in the answer also the proof that the other segment was read."""
NUMBER_IN_OPEN, DATA_IN_OPEN = 0x22, 0x42
"""In OPEN: the proof that the other segment was read, as a number until Zenoh 1.9, as data since 1.10."""
MARK_OF_PUT = 0x02 | MANDATORY
MARK_OF_QUERY = 0x04

MOST_SLICES = 1024
"""Slices of one payload. rmw_zenoh and eclipse-zenoh write one or two."""
_RAW, _POINTER = 0, 1


class Pointer(NamedTuple):
    """A pointer to a chunk, by its header in one of its owner's metadata segments."""

    size: int
    """Bytes of the chunk that belong to the payload."""
    segment: int
    """The id of the metadata segment, of 16 bits."""
    header: int
    """The place of the chunk's header in the metadata segment."""
    generation: int
    """Counts the uses of the header. If the header has another value, the chunk was reused."""


Slices: TypeAlias = Sequence[bytes | Pointer]


@runtime_checkable
class Loan(Protocol):
    """A chunk of this session's pool that is being published."""

    def write(self, payload: bytes | memoryview | Parts) -> bool:
        """Copy the payload into the chunk; False if the pool was closed meanwhile."""

    def narrow(self, start: int, size: int) -> None:
        """Shorten the payload to `size` bytes from `start` on; the rest is not sent."""

    @property
    def view(self) -> memoryview:
        """The payload, which may be written to until it is published."""

    def end(self) -> None:
        """Give the chunk up: it is free when no reader uses it any more."""


class LinkMemory(Protocol):
    """The shared memory of one link, in both directions. No method blocks."""

    def lend(self, loan: Loan) -> Pointer | None:
        """Return a pointer for the other side; None if this message must go as bytes. Any thread."""

    def take_back(self, pointer: Pointer) -> None:
        """Take back a pointer that was not sent."""

    def take(self, slices: Slices, priority: int, *, as_view: bool) -> bytes | memoryview | None:
        """Return the payload of a received message; None if its sender has reused the chunk.

        With `as_view` it may be a view of the chunk, which stays as it is while the view lives. Raises
        ZenohProtocolError for pointers that lead nowhere.
        """

    def close(self) -> None:
        """Give up all chunks, lent and borrowed: the link has ended."""


class Pool(Protocol):
    """The memory from which a session publishes."""

    @property
    def least(self) -> int:
        """Bytes of the smallest payload that goes through shared memory."""

    def borrow(self, size: int) -> Loan | None:
        """Return a chunk; None if the pool is full. It never waits."""


def encode_pointer(pointer: Pointer) -> bytes:
    """Return a payload that consists of one pointer."""
    size, segment, header, generation = pointer
    body = encode_z(size) + encode_z(segment) + encode_z(header) + encode_z(generation)
    return b'\x01\x01' + encode_data(body)


def read_slices(data: bytes, at: int, end: int) -> tuple[Slices, int]:
    """Return the slices at `at` and the position after them. Raises ZenohProtocolError or IndexError."""
    count, at = decode_z(data, at)
    if not 0 < count <= MOST_SLICES:
        raise ZenohProtocolError(f'a payload of {count} slices')
    slices: list[bytes | Pointer] = []
    for _ in range(count):
        kind = data[at]
        size, at = decode_z(data, at + 1)
        slice_end = at + size
        if slice_end > end:
            raise ZenohProtocolError('a slice is cut off')
        if kind == _RAW:
            slices.append(data[at:slice_end])
        elif kind == _POINTER:
            slices.append(_read_pointer(data, at, slice_end))
        else:
            raise ZenohProtocolError(f'a slice of kind {kind}')
        at = slice_end
    return slices, at


def _read_pointer(data: bytes, at: int, end: int) -> Pointer:
    """Read the numbers of a pointer, each within the size that the segments have for it."""
    size, at = decode_z(data, at)
    segment, at = decode_z(data, at)
    header, at = decode_z(data, at)
    generation, at = decode_z(data, at)
    if at != end or not size or segment >> 16 or header >> 16 or generation >> 32:
        raise ZenohProtocolError('an impossible pointer to shared memory')
    return Pointer(size, segment, header, generation)
