"""Starts missions at times of the day or every so many seconds: each slot of a schedule once.

A mission's id is made of the schedule's name and its slot, and a known id is not started again. So no slot is
carried out twice: not after a restart, and not after a clock that went back.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Awaitable, Callable
from datetime import datetime, timedelta
from typing import Literal

from goalwire.records import record

Missed = Literal['skip', 'run']
_TIME_OF_DAY = re.compile(r'([01]\d|2[0-3]):([0-5]\d)')
_LOOK_S = 60.0
"""How long, in s, it may take to notice that the clock was set."""


@record
class Slots:
    """The times of a schedule: `daily` at a time of the local day, or at every multiple of `every` s since
    1970.
    """

    daily: str | None = None
    every: float | None = None

    def __post_init__(self) -> None:
        if (self.daily is None) == (self.every is None):
            raise ValueError("a schedule has daily='HH:MM' or every=SECONDS, one of them")
        if self.daily is not None and not _TIME_OF_DAY.fullmatch(self.daily):
            raise ValueError(f"daily is a time of the day such as '02:00', not {self.daily!r}")
        if self.every is not None and not 1.0 <= self.every < float('inf'):
            raise ValueError(f'every is a number of seconds, at least 1, not {self.every!r}')

    def after(self, now: float) -> float:
        """Return the first slot after `now`; both in s since 1970."""
        if self.every is not None:
            return (now // self.every + 1.0) * self.every
        slot = self._today(now)
        return slot if slot > now else self._today(now, days=1)

    def latest(self, now: float) -> float:
        """Return the last slot at or before `now`."""
        if self.every is not None:
            return now // self.every * self.every
        slot = self._today(now)
        return slot if slot <= now else self._today(now, days=-1)

    def _today(self, now: float, days: int = 0) -> float:
        assert self.daily is not None
        hour, minute = map(int, self.daily.split(':'))
        day = datetime.fromtimestamp(now).astimezone().date() + timedelta(days=days)
        # A naive time is local: so days of 23 or 25 hours, when summer time begins or ends, need no care.
        return datetime(day.year, day.month, day.day, hour, minute).timestamp()  # noqa: DTZ001


def slot_id(name: str, slot: float) -> str:
    """Return the id of the mission that a slot starts."""
    return f'{name} {datetime.fromtimestamp(slot).astimezone().isoformat(timespec="seconds")}'


async def keep_schedule(
    slots: Slots,
    since: float,
    missed: Missed,
    wall: Callable[[], float],
    start: Callable[[float], Awaitable[object]],
) -> None:
    """Start the mission of each slot, until cancelled.

    `since` is when the schedule was first kept. With `missed='run'` the latest slot since then, for which no
    runner was there, is started at once; `start` ignores a slot that it has started before.
    """
    now = wall()
    if missed == 'run' and slots.latest(now) > since:
        await start(slots.latest(now))
    slot = slots.after(now)
    while True:
        left = slot - wall()
        if left > 0:
            await asyncio.sleep(min(left, _LOOK_S))
            slot = min(slot, slots.after(wall()))  # the clock may have been set back
        else:
            await start(slot)
            slot = slots.after(max(wall(), slot))
