"""The payloads of an action whose layout does not depend on the action's type (CDR, action_msgs).

A goal id is sixteen plain bytes at the beginning of a payload, so the data after the id have the same
alignment as without the id. So a serialized goal or feedback is cut out of its wrapper message, or put into
it, without being decoded.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import TypeAlias

from goalwire.errors import RemoteError
from goalwire.rules.goals.cancel_requests import CancelCode
from goalwire.rules.goals.ids import ID_LENGTH, GoalId
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.time import LATEST_STAMP, S_TO_NS

Payload: TypeAlias = bytes | bytearray | memoryview

_HEADER = b'\x00\x01\x00\x00'
_START = len(_HEADER)
_INNER = _START + ID_LENGTH
_STATUSES = tuple(GoalStatus)
"""The statuses by their numbers. The look-up of an enum would take two calls."""
_ACCEPTANCE = struct.Struct('<4s?3xiI')
_REASON_MARK = b'\x00goalwire-why\x00'
_REASON_LENGTH = struct.Struct('<H')
_REASON_TAIL = _REASON_LENGTH.size + len(_REASON_MARK)
_ALIGNMENT = 4
"""The alignment of messages on DDS. Without it, DDS would add bytes after the mark."""
REASON_LIMIT = 1000
"""The most bytes of a reason that are sent. The rest is cut off."""
_CANCEL_HEAD = struct.Struct('<4sb3xI')
_STAMP = {1: struct.Struct('<iI'), 0: struct.Struct('>iI')}


def unwrap(payload: Payload) -> tuple[GoalId, bytes]:
    """Split a send_goal request or a feedback message into goal id and the serialized goal or feedback.

    Raises RemoteError for a payload too short to hold an id.
    """
    if len(payload) < _INNER:
        raise RemoteError(f'a goal id takes {_INNER} bytes of payload, got {len(payload)}')
    return bytes(payload[_START:_INNER]), bytes(payload[:_START]) + bytes(payload[_INNER:])


def wrap(goal_id: GoalId, message: bytes) -> bytes:
    """Put a goal id before a serialized goal or feedback, behind the CDR header."""
    return message[:_START] + goal_id + message[_START:]


def goal_id_of(payload: Payload) -> GoalId:
    """Return the goal id that a payload begins with; raises RemoteError for a payload that is too short."""
    if len(payload) < _INNER:
        raise RemoteError(f'a goal id takes {_INNER} bytes of payload, got {len(payload)}')
    return bytes(payload[_START:_INNER])


def encode_result_request(goal_id: GoalId) -> bytes:
    """Serialize a get_result request."""
    return _HEADER + goal_id


def encode_acceptance(accepted: bool, stamp_ns: int) -> bytes:
    """Serialize a send_goal reply; `stamp_ns` is ROS time."""
    return _ACCEPTANCE.pack(_HEADER, accepted, *divmod(min(stamp_ns, LATEST_STAMP), S_TO_NS))


def is_acceptance(payload: Payload) -> bool:
    """Tell whether a send_goal reply accepts the goal. A reply that is too short counts as a refusal."""
    return len(payload) > _START and payload[_START] != 0


def status_of(payload: Payload) -> GoalStatus:
    """Read the status that a get_result reply begins with; UNKNOWN for a number without a meaning."""
    try:
        return _STATUSES[payload[_START]]
    except IndexError:
        return GoalStatus.UNKNOWN


def with_status(payload: bytes, status: GoalStatus) -> bytes:
    """Return a copy of a get_result reply with another status."""
    return payload[:_START] + bytes((status,)) + payload[_START + 1 :]


def with_reason(payload: bytes, reason: str) -> bytes:
    """Add to a get_result reply the reason why the goal was aborted.

    The deserializers of ROS 2 (Fast CDR; Cyclone DDS under its rmw) ignore bytes after a message. So a client
    of ROS 2 reads the reply as usual.
    """
    text = reason.encode(errors='replace')[:REASON_LIMIT]
    text += bytes(-(len(payload) + len(text) + _REASON_TAIL) % _ALIGNMENT)
    return b''.join((payload, text, _REASON_LENGTH.pack(len(text)), _REASON_MARK))


def split_reason(payload: Payload) -> tuple[Payload, str]:
    """Split a get_result reply into ROS 2's part and the reason for the abort ('' without a reason)."""
    if payload[-len(_REASON_MARK) :] != _REASON_MARK:
        return payload, ''
    end = len(payload) - _REASON_TAIL
    if end < 0:
        return payload, ''
    start = end - _REASON_LENGTH.unpack_from(payload, end)[0]
    if start <= _START:
        return payload, ''
    return payload[:start], bytes(payload[start:end]).rstrip(b'\0').decode(errors='replace')


def encode_cancel_request(goal_id: GoalId, stamp_ns: int = 0) -> bytes:
    """Serialize a cancel_goal request."""
    return _HEADER + goal_id + _STAMP[1].pack(*divmod(min(stamp_ns, LATEST_STAMP), S_TO_NS))


def decode_cancel_request(payload: Payload) -> tuple[GoalId, int]:
    """Return id and stamp (ns) of a cancel_goal request; raises RemoteError if the request is too short."""
    goal_id = goal_id_of(payload)
    try:
        seconds, nanoseconds = _STAMP[payload[1] & 1].unpack_from(payload, _INNER)
    except struct.error:
        raise RemoteError(f'a cancel request takes {_INNER + 8} bytes, got {len(payload)}') from None
    return goal_id, seconds * S_TO_NS + nanoseconds


def encode_cancel_reply(code: CancelCode, goals: Iterable[tuple[GoalId, int]]) -> bytes:
    """Serialize a cancel_goal reply: its code, and ids and stamps (ns) of the goals that are CANCELING."""
    entries = [
        goal_id + _STAMP[1].pack(*divmod(min(stamp_ns, LATEST_STAMP), S_TO_NS)) for goal_id, stamp_ns in goals
    ]
    return b''.join((_CANCEL_HEAD.pack(_HEADER, code, len(entries)), *entries))
