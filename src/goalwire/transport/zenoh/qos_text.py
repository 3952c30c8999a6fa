"""QoS as liveliness tokens spell it: every policy that is not rmw_zenoh's default, in decimal.

`<reliability>:<durability>:<history>,<depth>:<deadline s>,<ns>:<lifespan s>,<ns>:<liveliness>,<lease s>,<ns>`
Source: rmw_zenoh_cpp src/detail/qos.cpp and liveliness_utils.cpp.
"""

from __future__ import annotations

from enum import IntEnum
from functools import lru_cache
from typing import TypeVar

from goalwire.errors import LocalError, RemoteError
from goalwire.rules.qos import (
    INFINITE_NS,
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)

DEFAULT_DEPTH = 42
"""The depth a user gets who asks for 0."""

_DIGITS = 20
"""As many as the greatest number of 64 bits has."""

_SECOND = 1_000_000_000
_INFINITE = divmod(INFINITE_NS, _SECOND)

P = TypeVar('P', bound=IntEnum)


def actual_depth(qos: QoS) -> int:
    """Return how many messages are kept."""
    return qos.depth or DEFAULT_DEPTH


@lru_cache(maxsize=256)  # a node's standing services alone ask for the same seven times
def encode_qos(qos: QoS) -> str:
    """Return a token's QoS chunk; raises LocalError for a policy that is UNKNOWN."""
    for name in ('reliability', 'durability', 'history', 'liveliness'):
        if getattr(qos, name).name == 'UNKNOWN':
            raise LocalError(f'QoS: {name} is UNKNOWN, which no endpoint can have; choose a policy')
    depth = actual_depth(qos)
    return ':'.join(
        (
            _policy(qos.reliability, ReliabilityPolicy.RELIABLE),
            _policy(qos.durability, DurabilityPolicy.VOLATILE),
            f'{_policy(qos.history, HistoryPolicy.KEEP_LAST)},{"" if depth == DEFAULT_DEPTH else depth}',
            _duration(qos.deadline_ns),
            _duration(qos.lifespan_ns),
            f'{_policy(qos.liveliness, LivelinessPolicy.AUTOMATIC)},{_duration(qos.lease_ns)}',
        )
    )


def decimal(text: str) -> int:
    """Read a number of a token; raises ValueError where it is none, or longer than any that rmw writes."""
    if not (text.isascii() and text.isdigit() and len(text) <= _DIGITS):
        raise ValueError(f"'{text}' is not a decimal number of at most {_DIGITS} digits")
    return int(text)


def _policy(value: IntEnum, default: IntEnum) -> str:
    is_default = value in (default, 0)  # 0 is SYSTEM_DEFAULT everywhere
    return '' if is_default else str(value.value)


def _duration(nanoseconds: int) -> str:
    """Seconds and nanoseconds, each empty where it equals its half of infinity; 0 means infinity."""
    halves = divmod(nanoseconds or INFINITE_NS, _SECOND)
    return ','.join('' if half == whole else str(half) for half, whole in zip(halves, _INFINITE, strict=True))


@lru_cache(maxsize=256)
def decode_qos(text: str) -> QoS:
    """Read a token's QoS chunk; raises RemoteError where it does not follow the grammar."""
    try:
        reliability, durability, history, deadline, lifespan, liveliness = text.split(':')
        history_kind, depth = history.split(',')
        liveliness_kind, lease = liveliness.split(',', 1)
        return QoS(
            depth=_number(depth, DEFAULT_DEPTH),
            history=_member(HistoryPolicy, history_kind, HistoryPolicy.KEEP_LAST),
            reliability=_member(ReliabilityPolicy, reliability, ReliabilityPolicy.RELIABLE),
            durability=_member(DurabilityPolicy, durability, DurabilityPolicy.VOLATILE),
            deadline_ns=_nanoseconds(deadline),
            lifespan_ns=_nanoseconds(lifespan),
            liveliness=_member(LivelinessPolicy, liveliness_kind, LivelinessPolicy.AUTOMATIC),
            lease_ns=_nanoseconds(lease),
        )
    except ValueError as error:
        raise RemoteError(f"QoS '{text}' of a liveliness token: {error}") from None


def _number(text: str, default: int) -> int:
    return decimal(text) if text else default


def _member(kind: type[P], text: str, default: P) -> P:
    return kind(_number(text, default.value))


def _nanoseconds(text: str) -> int:
    halves = zip(text.split(','), _INFINITE, strict=True)
    seconds, nanoseconds = (_number(half, whole) for half, whole in halves)
    return min(seconds * _SECOND + nanoseconds, INFINITE_NS)
