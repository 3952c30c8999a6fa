"""Reads faults from text, for GOALWIRE_FAULTS: `seed 7; loss rate=0.1 name=/scan; kill arm goal_accepted`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TypeAlias

from goalwire.errors import TransportError
from goalwire.transport.faults.kinds import (
    Delay,
    Duplication,
    FailedCall,
    FlippedBytes,
    Kill,
    Kind,
    Loss,
    LostReply,
    Partition,
    Point,
    Reordering,
    SlowReader,
)
from goalwire.transport.faults.plan import AnyFault
from goalwire.transport.faults.session import Faults

_KINDS: dict[str, Callable[..., AnyFault]] = {
    'delay': Delay,
    'duplication': Duplication,
    'failed_call': FailedCall,
    'flipped_bytes': FlippedBytes,
    'kill': Kill,
    'loss': Loss,
    'lost_reply': LostReply,
    'partition': Partition,
    'reordering': Reordering,
    'slow_reader': SlowReader,
}
Value: TypeAlias = str | int | float | bool | Kind | Point
_WORDS: dict[str, Value] = {
    'yes': True,
    'no': False,
    **{kind.value: kind for kind in Kind},
    **{point.name.lower(): point for point in Point},
}


@cache
def parse(text: str) -> Faults:
    """Return the faults that a text names, the same object each time. Raises TransportError."""
    seed, faults = 0, []
    for part in text.split(';'):
        words = part.split()
        if words[:1] == ['seed'] and len(words) == 2 and words[1].isdecimal():
            seed = int(words[1])
        elif words:
            faults.append(_fault(part.strip(), words))
    return Faults(*faults, seed=seed)


def _fault(part: str, words: list[str]) -> AnyFault:
    kind = _KINDS.get(words[0])
    if kind is None:
        raise _refuse(part, f"there is no '{words[0]}'; choose one of: seed, {', '.join(_KINDS)}")
    values = [_value(word) for word in words[1:] if '=' not in word]
    named = {name: _value(text) for name, sign, text in (word.partition('=') for word in words[1:]) if sign}
    try:
        return kind(*values, **named)
    except (TypeError, ValueError) as error:
        raise _refuse(part, str(error)) from None


def _value(word: str) -> Value:
    if word in _WORDS:
        return _WORDS[word]
    for number in (int, float):
        try:
            return number(word)
        except ValueError:
            continue
    return word


def _refuse(part: str, problem: str) -> TransportError:
    return TransportError(f"GOALWIRE_FAULTS: '{part}': {problem}")
