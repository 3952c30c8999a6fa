"""The status array that a server publishes: every goal it retains, in the order of acceptance.

Its payload is CDR (action_msgs/msg/GoalStatusArray, little endian): a length, then per goal 16 bytes of id,
the stamp's int32 seconds and uint32 nanoseconds, one byte of status. The stamp is aligned to 4, so that
every entry but the first has three bytes of padding behind its id and is 28 bytes long. An entry is encoded
once; a transition changes its last byte.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from goalwire.errors import RemoteError
from goalwire.protocol.goals.ids import ID_LENGTH
from goalwire.protocol.goals.table import GoalStatus

if TYPE_CHECKING:
    from goalwire.protocol.goals.ids import GoalId

_HEADER = b'\x00\x01\x00\x00'
_LITTLE_ENDIAN, _BIG_ENDIAN = b'\x00\x01', b'\x00\x00'
_COUNT = struct.Struct('<I')
_STAMP = struct.Struct('<iI')
_PADDING = bytes(3)
_ENTRY = ID_LENGTH + len(_PADDING) + _STAMP.size + 1
_FIRST_ENTRY = _ENTRY - len(_PADDING)
_PREFIX = len(_HEADER) + _COUNT.size
_STATUSES = tuple(GoalStatus)
_STATUS_BYTES = tuple(bytes((status,)) for status in GoalStatus)
_S_TO_NS = 1_000_000_000


class StatusArray:
    """The retained goals' entries, and which of them have changed since the array was last taken."""

    def __init__(self) -> None:
        self._entries: dict[GoalId, bytes] = {}
        self._untaken: set[GoalId] = set()
        self._leaving: set[GoalId] = set()

    def __len__(self) -> int:
        return len(self._entries)

    def add(self, goal_id: GoalId, stamp_ns: int, status: GoalStatus) -> None:
        """Append a goal accepted at `stamp_ns` (ROS time)."""
        self._entries.pop(goal_id, None)
        self._leaving.discard(goal_id)
        stamp = _STAMP.pack(*divmod(stamp_ns, _S_TO_NS))
        self._entries[goal_id] = goal_id + _PADDING + stamp + _STATUS_BYTES[status]
        self._untaken.add(goal_id)

    def update(self, goal_id: GoalId, status: GoalStatus) -> None:
        """Note a goal's new status."""
        self._entries[goal_id] = self._entries[goal_id][:-1] + _STATUS_BYTES[status]
        self._untaken.add(goal_id)

    def remove(self, goal_id: GoalId) -> None:
        """Drop a goal that has ended, but not before its end has been taken once."""
        if goal_id in self._untaken:
            self._leaving.add(goal_id)
        else:
            del self._entries[goal_id]

    def take(self) -> bytes | None:
        """Return the payload to publish; None where nothing has changed since the last one."""
        if not self._untaken:
            return None
        payload = self.encode()
        for goal_id in self._leaving:
            del self._entries[goal_id]
        self._untaken.clear()
        self._leaving.clear()
        return payload

    def encode(self) -> bytes:
        """Return the array as it stands, as a serialised GoalStatusArray."""
        entries = list(self._entries.values())
        if entries:
            entries[0] = entries[0][:ID_LENGTH] + entries[0][ID_LENGTH + len(_PADDING) :]
        return b''.join((_HEADER, _COUNT.pack(len(entries)), *entries))


def decode_status_array(payload: bytes) -> list[tuple[GoalId, GoalStatus]]:
    """Read what a server published, of either byte order, without its stamps.

    Raises RemoteError for a payload of the wrong length or a status that ROS 2 does not know.
    """
    order = payload[:2]
    if len(payload) < _PREFIX or order not in {_LITTLE_ENDIAN, _BIG_ENDIAN}:
        raise RemoteError(f'GoalStatusArray of {len(payload)} bytes has no CDR header: {payload[:8].hex()}')
    count = int.from_bytes(payload[4:_PREFIX], 'little' if order == _LITTLE_ENDIAN else 'big')
    end = _PREFIX + _ENTRY * count - len(_PADDING) if count else _PREFIX
    if not end <= len(payload) < end + 4:
        raise RemoteError(f'GoalStatusArray of {count} entries takes {end} bytes, got {len(payload)}')
    if not count:
        return []
    first = _PREFIX - len(_PADDING)  # where the first entry would start if it were padded too
    try:
        return [
            (payload[max(at, _PREFIX) : max(at, _PREFIX) + ID_LENGTH], _STATUSES[payload[at + _ENTRY - 1]])
            for at in range(first, first + _ENTRY * count, _ENTRY)
        ]
    except IndexError:
        raise RemoteError('GoalStatusArray holds a status beyond ABORTED (6)') from None
