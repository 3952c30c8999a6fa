"""Decides whether a mission may go on by itself after its runner was away.

A machine must not start to move just because its power has returned.
"""

from __future__ import annotations

from typing import Literal

from goalwire.records import record

DOWN_S = 60.0
"""The longest absence of a runner, in s, after which missions go on without a person's confirmation."""

Resume = Literal['ask', 'auto']


@record
class Sighting:
    """A moment at which a runner was alive: its machine's boot id, and the time of its steady clock in s."""

    boot: str
    steady: float


def why_held(resume: Resume, last: Sighting | None, now: Sighting) -> str:
    """Return why a mission waits for a person after a restart of its runner; '' if it may go on."""
    if resume == 'auto':
        return ''
    if last is None or last.boot != now.boot:
        return 'the machine was restarted'
    away = now.steady - last.steady
    if not 0 <= away <= DOWN_S:
        return f'the runner was away for {away:.0f} s'
    return ''
