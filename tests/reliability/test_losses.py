"""Items 7 and 10: many calls on a wire that loses and delays, on memory in virtual time.

Nothing repeats what this wire loses, so every loss is a call that ends at its deadline: all that were sent
are answered or fail by type.
"""

from __future__ import annotations

import asyncio

import pytest
from helpers.outcomes import Outcomes
from helpers.patience import PATIENCE
from std_srvs.srv import Trigger

from goalwire.testing import VirtualClock
from goalwire.transport.faults import Delay, Duplication, Fault, Loss, LostReply, Reordering

from .conftest import LONG, Evidence, MakeStage

ON_MEMORY = pytest.mark.parametrize('transport_name', ['goalwire_memory'], indirect=True)

CONDITIONS: dict[str, list[Fault]] = {
    'delay 20 ms': [Delay(0.02)],
    'delay 300 ms, jitter 50 ms': [Delay(0.3, jitter=0.05)],
    'loss 1 %': [Loss(rate=0.01)],
    'loss 10 %': [Loss(rate=0.1)],
    'half of the replies lost': [LostReply(rate=0.5)],
    'everything twice': [Duplication()],
    'reorder 25 %, delay 20 ms': [Delay(0.02), Reordering(rate=0.25)],
}

DEAD = 'every request lost, deadlines of 50 ms, 1000 at a time'


def call_often(stage: MakeStage, faults: list[Fault], number: int, at_once: int, seconds: float) -> Outcomes:
    """Make `number` calls, `at_once` at a time."""
    outcomes = Outcomes()

    async def scenario() -> None:
        async with stage() as (arm, mission, plan):
            arm.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
            client = mission.client(Trigger, 'ask')
            await client.wait_for_server(timeout=PATIENCE)
            for fault in faults:
                plan.add(fault)

            async def work() -> None:
                for _ in range(number // at_once):
                    with outcomes.counted():
                        await client.call(timeout=seconds)

            async with asyncio.TaskGroup() as group:
                for _ in range(at_once):
                    group.create_task(work())

    asyncio.run(scenario())
    return outcomes


@ON_MEMORY
@pytest.mark.parametrize('condition', CONDITIONS)
def test_all_that_are_sent_are_answered_or_fail_by_type(
    stage: MakeStage, evidence: Evidence, condition: str
) -> None:
    faults = CONDITIONS[condition]
    with VirtualClock():
        outcomes = call_often(stage, faults, number=500, at_once=10, seconds=2.0)
    lost = sum(fault.struck for fault in faults if isinstance(fault, Loss))
    assert outcomes.counts == {'done': 500 - lost} | ({'DeadlineError': lost} if lost else {})
    outcomes.slowest = None
    evidence(10, f'{condition} (virtual time)', outcomes)


@ON_MEMORY
def test_calls_to_a_dead_service_leave_nothing_in_any_table(stage: MakeStage, evidence: Evidence) -> None:
    with VirtualClock():
        outcomes = call_often(stage, [Loss()], number=3000, at_once=1000, seconds=0.05)
    assert outcomes.counts == {'DeadlineError': 3000}
    outcomes.slowest = None
    evidence(7, f'{DEAD} (virtual time)', outcomes)


@LONG
def test_calls_to_a_dead_service_in_real_time(stage: MakeStage, evidence: Evidence) -> None:
    outcomes = call_often(stage, [Loss()], number=3000, at_once=1000, seconds=0.05)
    assert outcomes.counts == {'DeadlineError': 3000}
    evidence(7, DEAD, outcomes)
