"""Item 17: the system's clock is set while calls wait. Deadlines are made of steady time."""

from __future__ import annotations

import asyncio
import time

import pytest
from helpers.loops import run
from helpers.outcomes import Outcomes
from helpers.patience import PATIENCE
from std_srvs.srv import Trigger

from .conftest import Evidence, MakeStage


@pytest.mark.parametrize('hours', [-1, 1])
def test_a_deadline_does_not_move_with_the_system_clock(
    stage: MakeStage, evidence: Evidence, monkeypatch: pytest.MonkeyPatch, hours: int
) -> None:
    outcomes = Outcomes()

    async def hang(_: Trigger.Request) -> Trigger.Response:
        began.set()
        await asyncio.Event().wait()
        raise AssertionError

    def jump() -> None:
        for name, unit in (('time', 1), ('time_ns', 10**9)):
            real = getattr(time, name)
            monkeypatch.setattr(time, name, lambda real=real, unit=unit: real() + hours * 3600 * unit)

    began = asyncio.Event()

    async def scenario() -> None:
        async with stage() as (arm, mission, _):
            arm.service(Trigger, 'hang', hang)
            arm.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
            client = mission.client(Trigger, 'hang')
            await client.wait_for_server(timeout=PATIENCE)
            asked = time.monotonic_ns()
            with outcomes.counted(lambda: asked):
                calling = asyncio.create_task(client.call(timeout=0.3))
                await began.wait()
                jump()
                await calling
            with outcomes.counted():
                await mission.client(Trigger, 'ask').call(timeout=PATIENCE)

    run(scenario())
    assert outcomes.counts == {'DeadlineError': 1, 'done': 1}
    assert outcomes.slowest is not None
    assert outcomes.slowest >= 0.3
    outcomes.expect_within(1.0)
    evidence(
        17, f'the clock is set {"back" if hours < 0 else "forward"} by an hour while a call waits', outcomes
    )
