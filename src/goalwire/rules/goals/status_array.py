"""The status array that a server publishes: every goal it retains, in the order of acceptance.

Its payload is CDR (action_msgs/msg/GoalStatusArray, little endian): a length, then per goal 16 bytes of id,
the stamp's int32 seconds and uint32 nanoseconds, one byte of status. The stamp is aligned to 4 bytes. So
every entry but the first has three bytes of padding between id and stamp, and is 28 bytes long.

An array is sent with every transition. With thousands of goals, a loop over all of them would take most of
the time of a transition (0.4 ms for 1000). So neither side loops: the server changes single bytes of the
previous array, and the client searches the bytes for the ids of its own goals.
"""

from __future__ import annotations

import struct
from bisect import bisect_left
from itertools import count as counter
from typing import TYPE_CHECKING

from goalwire.errors import RemoteError
from goalwire.rules.goals.ids import ID_LENGTH
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.time import LATEST_STAMP, S_TO_NS

if TYPE_CHECKING:
    from collections.abc import Collection

    from goalwire.rules.goals.ids import GoalId

_HEADER = b'\x00\x01\x00\x00'
_LITTLE_ENDIAN, _BIG_ENDIAN = b'\x00\x01', b'\x00\x00'
_COUNT = struct.Struct('<I')
_STAMP = struct.Struct('<iI')
_PADDING = bytes(3)
_ENTRY = ID_LENGTH + len(_PADDING) + _STAMP.size + 1
_PREFIX = len(_HEADER) + _COUNT.size
_START = _PREFIX - len(_PADDING)
"""The offset at which the first entry would begin if it were padded like the others."""
_ID_AND_STATUS = struct.Struct(f'{ID_LENGTH}s{_ENTRY - ID_LENGTH - 1}xB')
_STATUSES = tuple(GoalStatus)
_STATUS_BYTES = bytes(_STATUSES)
_FEW = 16
"""Up to this number of goals, a search for each id is faster than one loop over all entries."""


class StatusArray:
    """The entries of the retained goals, and which of them have changed since the last `take`."""

    def __init__(self) -> None:
        self._entries = bytearray()
        """The encoded GoalStatus entries, each after its padding. `encode` leaves the first padding out."""
        self._numbers: list[int] = []
        """The goals' numbers, ascending, in the order of their entries."""
        self._number_of: dict[GoalId, int] = {}
        self._next_number = counter().__next__
        self._untaken: set[GoalId] = set()
        self._leaving: set[GoalId] = set()

    def __len__(self) -> int:
        return len(self._numbers)

    def add(self, goal_id: GoalId, stamp_ns: int, status: GoalStatus) -> None:
        """Append a goal accepted at `stamp_ns` (ROS time)."""
        if goal_id in self._number_of:
            self._delete(goal_id)
        self._leaving.discard(goal_id)
        self._number_of[goal_id] = number = self._next_number()
        self._numbers.append(number)
        self._entries += (
            goal_id + _PADDING + _STAMP.pack(*divmod(min(stamp_ns, LATEST_STAMP), S_TO_NS)) + bytes((status,))
        )
        self._untaken.add(goal_id)

    def update(self, goal_id: GoalId, status: GoalStatus) -> None:
        """Note a goal's new status."""
        position = bisect_left(self._numbers, self._number_of[goal_id])
        self._entries[_ENTRY * position + _ENTRY - 1] = status
        self._untaken.add(goal_id)

    def remove(self, goal_id: GoalId) -> None:
        """Remove a goal that has ended, but not before a `take` has returned its final status."""
        if goal_id in self._untaken:
            self._leaving.add(goal_id)
        else:
            self._delete(goal_id)

    def take(self) -> bytes | None:
        """Return the payload to publish; None if no entry has changed since the last `take`."""
        if not self._untaken:
            return None
        payload = self.encode()
        for goal_id in self._leaving:
            self._delete(goal_id)
        self._untaken.clear()
        self._leaving.clear()
        return payload

    def encode(self) -> bytes:
        """Return the present array as a serialised GoalStatusArray."""
        with memoryview(self._entries) as entries:
            first, rest = entries[:ID_LENGTH], entries[ID_LENGTH + len(_PADDING) :]
            with first, rest:
                return b''.join((_HEADER, _COUNT.pack(len(self._numbers)), first, rest))

    def _delete(self, goal_id: GoalId) -> None:
        position = bisect_left(self._numbers, self._number_of.pop(goal_id))
        del self._numbers[position]
        del self._entries[_ENTRY * position : _ENTRY * (position + 1)]


def decode_status_array(payload: bytes) -> list[tuple[GoalId, GoalStatus]]:
    """Return the ids and statuses in a published status array of either byte order.

    Raises RemoteError for a payload of the wrong length or a status that ROS 2 does not know.
    """
    count = _count_entries(payload)
    if not count:
        return []
    first = payload[_PREFIX : _PREFIX + ID_LENGTH], payload[_START + _ENTRY - 1]
    others = _ID_AND_STATUS.iter_unpack(payload[_START + _ENTRY : _START + _ENTRY * count])
    return [(goal_id, _STATUSES[status]) for goal_id, status in (first, *others)]


def statuses_of(goals: Collection[GoalId], payload: bytes) -> list[tuple[GoalId, GoalStatus]]:
    """Read the statuses of `goals` only, in the order of the array.

    Raises the errors of decode_status_array.
    """
    if len(goals) > _FEW:
        return [entry for entry in decode_status_array(payload) if entry[0] in goals]
    end = _START + _ENTRY * _count_entries(payload)
    found: dict[int, tuple[GoalId, GoalStatus]] = {}
    for goal_id in goals:
        at = payload.rfind(goal_id, _PREFIX, end)  # the latest goals are at the end
        while at > _PREFIX and (at - _START) % _ENTRY:  # a match across two entries is not an id
            at = payload.rfind(goal_id, _PREFIX, at + ID_LENGTH - 1)
        if at >= 0:
            start = _START if at == _PREFIX else at
            found[start] = goal_id, _STATUSES[payload[start + _ENTRY - 1]]
    return list(map(found.__getitem__, sorted(found)))


def _count_entries(payload: bytes) -> int:
    """Check the length and the statuses of an array, and return the number of its entries."""
    order = payload[:2]
    if len(payload) < _PREFIX or order not in {_LITTLE_ENDIAN, _BIG_ENDIAN}:
        raise RemoteError(f'GoalStatusArray of {len(payload)} bytes has no CDR header: {payload[:8].hex()}')
    count = int.from_bytes(payload[4:_PREFIX], 'little' if order == _LITTLE_ENDIAN else 'big')
    end = _START + _ENTRY * count if count else _PREFIX
    if not end <= len(payload) < end + 4:
        raise RemoteError(f'GoalStatusArray of {count} entries takes {end} bytes, got {len(payload)}')
    if payload[_START + _ENTRY - 1 : end : _ENTRY].translate(None, _STATUS_BYTES):
        raise RemoteError('GoalStatusArray holds a status beyond ABORTED (6)')
    return count
