"""Items 9 and 10: faults of every kind that come and go at random under calls and goals, in virtual time.

Whatever happens, each ends by its deadline, with its answer or an error that says why; nothing waits then.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from random import Random

import pytest
from example_interfaces.action import Fibonacci
from helpers.outcomes import Outcomes
from std_srvs.srv import Trigger

import goalwire
from goalwire.entities.actions.client_requests import LATE_S
from goalwire.testing import VirtualClock
from goalwire.transport.faults import (
    Delay,
    Duplication,
    Fault,
    Faults,
    FlippedBytes,
    Kind,
    Loss,
    LostReply,
    Partition,
    Reordering,
    SlowReader,
)

from .conftest import LONG_ONES, Evidence, MakeStage, Stage

SEEDS = range(200 if LONG_ONES else 8)
WORKERS, JOBS = 8, 6
GRACE_S, CANCELLING_S = 0.5, 0.2
A_MOMENT_S = 0.02


def some_fault(rng: Random) -> Fault:
    """Make a fault of any kind."""
    rate = rng.choice([0.1, 0.5, 1.0])
    kinds: list[Callable[[], Fault]] = [
        lambda: Delay(rng.uniform(0.0, 0.5), jitter=rng.uniform(0.0, 0.2), rate=rate),
        lambda: Loss(rate=rate, kind=rng.choice(list(Kind))),
        lambda: LostReply(rate=rate),
        lambda: Duplication(rate=rate),
        lambda: Reordering(by=rng.uniform(0.0, 0.3), rate=rate),
        lambda: FlippedBytes(rate=rate / 2, number=rng.randrange(1, 9)),
        lambda: SlowReader(rng.uniform(0.0, 0.1), room=rng.randrange(1, 20)),
        lambda: Partition('arm', 'mission', one_way=rng.random() < 0.5, lease=rng.uniform(0.0, 1.0)),
        lambda: Partition('mission', 'arm', one_way=True, lease=rng.uniform(0.0, 1.0)),
    ]
    return rng.choice(kinds)()


async def make_trouble(faults: Faults, rng: Random) -> None:
    """Let faults come and go."""
    while True:
        await asyncio.sleep(rng.uniform(0.05, 0.4))
        faults.heal(*rng.sample(faults.active, k=len(faults.active) // 2) if rng.random() < 0.7 else ())
        faults.add(some_fault(rng))


async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
    for number in range(goal.request.order):
        goal.feedback(sequence=[number])
        await asyncio.sleep(0.1)
    return Fibonacci.Result(sequence=[goal.request.order])


class Worker:
    """Calls and sends goals, one after the other; each must end in time."""

    def __init__(self, stage: Stage, rng: Random, outcomes: Outcomes) -> None:
        self._rng = rng
        self._outcomes = outcomes
        self._ask = stage.mission.client(Trigger, 'ask')
        self._count = stage.mission.action(Fibonacci, 'count')

    async def work(self) -> None:
        for _ in range(JOBS):
            seconds = self._rng.uniform(0.05, 1.5)
            is_call, cancels_after = self._rng.random() < 0.6, self._rng.choice([None, None, 0.0, 0.3])
            most = seconds if is_call else seconds + (cancels_after or 0.0) + CANCELLING_S + GRACE_S
            began = time.monotonic()
            with self._outcomes.counted():
                if is_call:
                    await self._ask.call(timeout=seconds)
                else:
                    await self._send(seconds, cancels_after)
            took = time.monotonic() - began
            assert took <= most + A_MOMENT_S, f'{took:.3f} s instead of {most:.3f}'

    async def _send(self, seconds: float, cancels_after: float | None) -> None:
        order = self._rng.randrange(12)
        async with self._count.send(order=order, timeout=seconds, grace=GRACE_S) as goal:
            if cancels_after is not None:
                await asyncio.sleep(cancels_after)
                await goal.cancel(timeout=CANCELLING_S)
            assert len((await goal.result).sequence) == 1


@pytest.mark.parametrize('transport_name', ['goalwire_memory'], indirect=True)
def test_whatever_happens_everything_ends_in_time_and_nothing_waits(
    stage: MakeStage, evidence: Evidence
) -> None:
    outcomes = Outcomes()

    async def scenario(seed: int) -> None:
        rng = Random(seed)
        async with stage() as whole:
            whole.arm.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
            whole.arm.action_server(Fibonacci, 'count', count)
            trouble = asyncio.create_task(make_trouble(whole.faults, rng))
            async with asyncio.TaskGroup() as group:
                for _ in range(WORKERS):
                    group.create_task(Worker(whole, Random(rng.random()), outcomes).work())
            trouble.cancel()
            whole.faults.heal()
            await asyncio.sleep(
                LATE_S + 1.0
            )  # so long goals that were given up may be accepted, and cancelled

    for seed in SEEDS:
        with VirtualClock():
            asyncio.run(scenario(seed))
    assert outcomes.total == len(SEEDS) * WORKERS * JOBS
    outcomes.slowest = None
    evidence(9, 'faults of every kind come and go at random (virtual time)', outcomes)
