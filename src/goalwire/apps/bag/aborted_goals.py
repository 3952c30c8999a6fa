"""Writes a recorder's snapshot when a goal is aborted: the minutes before it say why."""

from __future__ import annotations

import asyncio
from contextlib import aclosing
from typing import TYPE_CHECKING

from goalwire.errors import BagError
from goalwire.observe.goal_topics import watch_ended_goals
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.apps.bag.recorder import Recorder

_STATUS = '/_action/status'
AFTER_S = 0.5
"""Seconds from the end of the goal to the snapshot, which so has the status and whatever followed it."""


async def snapshot_when_aborted(recorder: Recorder) -> None:
    """Write a snapshot whenever a goal of any action is aborted, until this coroutine is cancelled."""
    since = recorder.node.clock.now().nanoseconds / 1e9
    watched: set[str] = set()
    with recorder.node.graph.changes() as changes:
        async with asyncio.TaskGroup() as group:
            while True:
                for action in _actions(recorder) - watched:
                    watched.add(action)
                    group.create_task(_watch(recorder, action, since))
                await anext(changes)


def _actions(recorder: Recorder) -> set[str]:
    return {
        endpoint.name.removesuffix(_STATUS)
        for endpoint in recorder.node.graph.endpoints()
        if endpoint.kind is EndpointKind.PUBLISHER and endpoint.name.endswith(_STATUS)
    }


async def _watch(recorder: Recorder, action: str, since: float) -> None:
    async with aclosing(watch_ended_goals(recorder.node, action, since)) as goals:
        async for goal in goals:
            if goal.status == 'ABORTED':
                await asyncio.sleep(AFTER_S)
                await _write(recorder, f"'{action}' aborted goal {goal.goal_id}")


async def _write(recorder: Recorder, reason: str) -> None:
    try:
        count = await recorder.snapshot()
    except BagError as error:
        recorder.node.logger.warning(f'{reason}, and its snapshot is not written: {error}')
    else:
        recorder.node.logger.info(f'{reason}: a snapshot of {count:,} messages is written')
