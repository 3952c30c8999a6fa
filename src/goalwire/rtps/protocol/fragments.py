"""Cuts samples that are larger than a packet into fragments, and joins the fragments again.

`backlog` keeps the samples that are not whole yet, and drops those whose last fragment came too long ago.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.history import Change
from goalwire.rtps.protocol.messages import DataFrag
from goalwire.rtps.protocol.primitives import NumberSet, PacketParts, RtpsError

NEAR_FRAGMENT, FAR_FRAGMENT, MOST_FAR_FRAGMENT = 60_000, 1_344, 8_000
"""Bytes of a fragment to readers on this host; to others at first; to others after many fragments without a
loss. No network splits packets of the second size. A split packet is lost if one of its parts is, and then
fills the memory in which the receiving system reassembles packets: on Linux 4 MiB, kept for 30 s."""


class FragmentSizes(NamedTuple):
    """The sizes of the fragments of one writer, in bytes."""

    near: int
    far: int
    most_far: int


FRAGMENT_SIZES = FragmentSizes(NEAR_FRAGMENT, FAR_FRAGMENT, MOST_FAR_FRAGMENT)
PACKET_ROOM = 400
"""The most bytes that a packet has in addition to the payload."""
ON_THE_WAY_S = 0.005
"""How long requested fragments may take to arrive before they are requested again."""


def fragment_count(size: int, fragment_size: int) -> int:
    """Return the number of fragments of a sample."""
    return -(-size // fragment_size)


def cut(before: bytes, change: Change, reader: bytes, writer: bytes, fragment: int) -> PacketParts:
    """Return the parts of a packet: its beginning `before`, then DATA_FRAG with one fragment of a change."""
    payload, size = change.payload or b'', change.fragment_size
    piece = memoryview(payload)[(fragment - 1) * size : fragment * size]
    qos = change.qos if fragment == 1 else b''
    body = DataFrag(reader, writer, change.number, fragment, 1, size, len(payload), qos, piece, change.is_key)
    return body.parts(before)


class Partial:
    """A sample whose fragments have not all arrived."""

    __slots__ = (
        '_ahead',
        '_asked',
        '_joined',
        '_payload',
        'count',
        'fragment_size',
        'heard',
        'is_key',
        'kept',
        'qos',
        'size',
    )

    def __init__(self, first: DataFrag) -> None:
        """Raises RtpsError for a sample that is too large, or whose fragments are too small."""
        self.size, self.fragment_size = first.size, first.fragment_size
        is_cut_small = self.fragment_size < min(bounds.LEAST_FRAGMENT, self.size)
        if not self.size or self.size > bounds.SAMPLE_SIZE or is_cut_small:
            raise RtpsError(
                f'a sample of {self.size} bytes in fragments of {self.fragment_size} is refused: samples '
                f'have 1 to {bounds.SAMPLE_SIZE} bytes, fragments at least {bounds.LEAST_FRAGMENT}'
            )
        self.count = fragment_count(self.size, self.fragment_size)
        self.qos = b''
        self.is_key = first.is_key
        self.kept = 0
        """Bytes that have arrived."""
        self.heard = 0.0
        """When a fragment last arrived."""
        self._payload = bytearray()
        self._joined = 0
        """The payload's beginning, and how many fragments it consists of."""
        self._ahead: dict[int, bytes] = {}
        """The fragments that have come before earlier ones."""
        self._asked = (0, 0.0)
        """The first fragment of the last request, and the request's time."""

    def add(self, fragment: DataFrag) -> None:
        """Copy fragments into the sample; raises RtpsError if they do not belong to it."""
        first, size = fragment.first, self.fragment_size
        last = first + fragment.fragments - 1
        if (fragment.size, fragment.fragment_size) != (
            self.size,
            size,
        ) or not 0 < first <= last <= self.count:
            raise RtpsError(f'fragments {first} to {last} do not belong to a sample with {self.count}')
        payload = fragment.payload
        expected = min(last * size, self.size) - (first - 1) * size
        if len(payload) < expected:
            raise RtpsError(f'fragments of {expected} bytes have {len(payload)}')
        if fragment.qos:
            self.qos = fragment.qos
        for number in range(first, last + 1):
            if number > self._joined and number not in self._ahead:
                at = (number - first) * size
                self._take(number, payload[at : min(at + size, expected)])

    def _take(self, number: int, piece: bytes | memoryview) -> None:
        """Append a fragment to the payload, or keep it until all earlier fragments have come."""
        self.kept += len(piece)
        if number > self._joined + 1:
            self._ahead[number] = bytes(piece)
            return
        self._payload += piece
        self._joined = number
        while (following := self._ahead.pop(self._joined + 1, None)) is not None:
            self._payload += following
            self._joined += 1

    @property
    def is_whole(self) -> bool:
        """True if all fragments have arrived."""
        return self.kept == self.size

    @property
    def payload(self) -> bytearray:
        """The payload; valid once the sample is whole. It does not change after that."""
        return self._payload

    def to_ask(self, now: float, last: int | None = None) -> NumberSet | None:
        """Return the missing fragments up to `last`, to be requested.

        Returns None if all have arrived, or if the same fragments were requested a moment ago and may be on
        their way.
        """
        end = self.count if last is None else min(last, self.count)
        missing = _first_missing(range(self._joined + 1, end + 1), self._ahead)
        if missing is None or (missing.base == self._asked[0] and now < self._asked[1] + ON_THE_WAY_S):
            return None
        self._asked = missing.base, now
        return missing


def _first_missing(numbers: Iterable[int], found: dict[int, bytes]) -> NumberSet | None:
    missing: list[int] = []
    for number in numbers:
        if number not in found:
            missing.append(number)
        if missing and number - missing[0] >= bounds.SET_BITS - 1:
            break
    return NumberSet.of(missing[0], missing) if missing else None
