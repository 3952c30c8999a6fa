"""Writes a recorder's snapshot when a goal is aborted: the minutes before it say why."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Coroutine
from contextlib import aclosing, asynccontextmanager
from typing import TYPE_CHECKING

from goalwire.errors import BagError, peer_text
from goalwire.observe.goal_topics import watch_ended_goals
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.apps.bag.recorder import Recorder

_STATUS = '/_action/status'
AFTER_S = 0.5
"""Seconds from the end of the goal to the snapshot, which so has the status and whatever followed it."""


@asynccontextmanager
async def snapshots_of_aborts(recorder: Recorder) -> AsyncIterator[None]:
    """Write a snapshot whenever a goal of any action is aborted, until the block ends.

    If a watch fails, that is logged at once, and the recording goes on.
    """
    watching = asyncio.create_task(_report(recorder, 'the goals of all actions', _watch_all(recorder)))
    try:
        yield
    finally:
        watching.cancel()
        await asyncio.wait([watching])


async def _report(recorder: Recorder, watched: str, watch: Coroutine[None, None, None]) -> None:
    """Run a watch, and log why it fails: one action that cannot be watched must not end the others."""
    try:
        await watch
    except Exception as error:
        reason = peer_text(str(error).partition('\n')[0])
        recorder.node.logger.error(f'an abort writes no snapshot: {watched} cannot be watched: {reason}')


async def _watch_all(recorder: Recorder) -> None:
    since = recorder.node.clock.now().nanoseconds / 1e9
    watched: set[str] = set()
    with recorder.node.graph.changes() as changes:
        async with asyncio.TaskGroup() as group:
            while True:
                for action in _actions(recorder) - watched:
                    watched.add(action)
                    watch = _watch(recorder, action, since)
                    group.create_task(_report(recorder, f"the goals of '{peer_text(action)}'", watch))
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
