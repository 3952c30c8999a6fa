"""The events that a running mission reports: as dataclasses, and as lines of text between processes."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass

MARK = '@mission '  # prefix of a line that carries an event


@dataclass(frozen=True)
class Began:
    """Step `number` of `total` (from 1) begins."""

    number: int
    total: int
    name: str
    expected: str


@dataclass(frozen=True)
class Progressed:
    """The progress of a step, 0 to 1, and a text about it."""

    number: int
    fraction: float
    text: str


@dataclass(frozen=True)
class Retrying:
    """An attempt got no answer; the next one follows after `wait` seconds."""

    number: int
    attempt: int
    wait: float
    reason: str


@dataclass(frozen=True)
class Finished:
    """A step has ended; `ok` is True if it went as expected."""

    number: int
    ok: bool
    happened: str
    seconds: float


Event = Began | Progressed | Retrying | Finished
Sink = Callable[[Event], None]

_KINDS: dict[str, type[Event]] = {kind.__name__: kind for kind in (Began, Progressed, Retrying, Finished)}


def to_line(event: Event) -> str:
    return MARK + json.dumps({'event': type(event).__name__, **asdict(event)})


def from_line(line: str) -> Event | None:
    """Return the event in a line of a mission's output, or None for other text."""
    if not line.startswith(MARK):
        return None
    fields = json.loads(line[len(MARK) :])
    return _KINDS[fields.pop('event')](**fields)
