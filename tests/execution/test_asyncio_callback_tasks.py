"""The book of callbacks under way."""

from __future__ import annotations

import asyncio

from helpers.loops import run

from goalwire.execution.asyncio.executor import CallbackTasks
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue


def test_cancelling_a_work_spares_others_and_the_caller() -> None:
    async def scenario() -> list[bool]:
        runs, one, other = (
            CallbackTasks(),
            CallbackSource(NodeWorkQueue(), None),
            CallbackSource(NodeWorkQueue(), None),
        )

        async def forever() -> None:
            await asyncio.Event().wait()

        async def canceller() -> None:
            runs.cancel(one)
            await asyncio.sleep(0)

        tasks = [asyncio.create_task(run) for run in (forever(), forever(), canceller())]
        for task, source in zip(tasks, (one, other, one), strict=True):
            runs.add(task, source)
        await tasks[2]
        cancelled = [task.cancelled() for task in tasks]
        for task in tasks:
            runs.discard(task)
        assert len(runs) == 0
        runs.cancel_all()
        tasks[1].cancel()
        return cancelled

    assert run(scenario()) == [True, False, False]


def test_nothing_runs_outside_a_loop_and_nothing_is_cancelled() -> None:
    runs = CallbackTasks()
    runs.cancel_all()  # asks asyncio for no task: there is no loop to ask
    assert len(runs) == 0
