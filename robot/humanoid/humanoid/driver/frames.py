"""The frames of the example driver: how numbers are sent over a serial line that may lose bytes.

    A5 5A | kind | number | length (2) | payload | CRC-16 (2)

All little-endian. The CRC (CCITT, from FFFF) is over kind, number, length and payload. TARGETS has an index
and a float32 for each joint that is to move; the board answers it with STATES of the same number: position,
velocity and effort of each joint, float32, in the order of their indices. A board that gets no frame for half
a second lets its motors hold their positions.
"""

from __future__ import annotations

import binascii
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

MAGIC = b'\xa5\x5a'
TARGETS, STATES = 1, 2
LONGEST = 4096  # bytes that a payload may have
_HEAD = struct.Struct('<BBH')
_TARGET = struct.Struct('<Hf')
_STATE = struct.Struct('<fff')


@dataclass(frozen=True)
class Frame:
    kind: int
    number: int
    payload: bytes

    def encode(self) -> bytes:
        body = _HEAD.pack(self.kind, self.number, len(self.payload)) + self.payload
        return MAGIC + body + struct.pack('<H', _crc(body))


def targets(number: int, positions: Mapping[int, float]) -> Frame:
    return Frame(TARGETS, number, b''.join(_TARGET.pack(*each) for each in positions.items()))


def states(number: int, joints: Sequence[tuple[float, float, float]]) -> Frame:
    return Frame(STATES, number, b''.join(_STATE.pack(*each) for each in joints))


def positions_of(frame: Frame) -> Mapping[int, float]:
    """Return the target position for each joint index. Raises ValueError unless it is a TARGETS frame."""
    if frame.kind != TARGETS or len(frame.payload) % _TARGET.size:
        raise ValueError('no targets')
    return dict(_TARGET.iter_unpack(frame.payload))


def joints_of(frame: Frame) -> Sequence[tuple[float, float, float]]:
    """Return the joints in a payload of STATES; a last joint that is cut off is left out."""
    whole = len(frame.payload) // _STATE.size * _STATE.size
    return list(_STATE.iter_unpack(frame.payload[:whole]))


class Decoder:
    """Finds frames in the bytes of a line. After a damaged frame it continues with the next whole one."""

    def __init__(self) -> None:
        self.damaged = 0  # number of frames with a wrong checksum
        self._kept = b''

    def feed(self, data: bytes) -> Iterator[Frame]:
        self._kept += data
        while True:
            start = self._kept.find(MAGIC)
            if start < 0:
                self._kept = self._kept[-1:] if self._kept.endswith(MAGIC[:1]) else b''
                return
            self._kept = self._kept[start:]
            if len(self._kept) < len(MAGIC) + _HEAD.size:
                return
            kind, number, length = _HEAD.unpack_from(self._kept, len(MAGIC))
            end = len(MAGIC) + _HEAD.size + length
            if length <= LONGEST:
                if len(self._kept) < end + 2:
                    return
                body = self._kept[len(MAGIC) : end]
                if self._kept[end : end + 2] == struct.pack('<H', _crc(body)):
                    self._kept = self._kept[end + 2 :]
                    yield Frame(kind, number, body[_HEAD.size :])
                    continue
            self.damaged += 1
            self._kept = self._kept[1:]  # drop one byte only: a real frame may begin inside the damaged one


def _crc(data: bytes) -> int:
    return binascii.crc_hqx(data, 0xFFFF)
