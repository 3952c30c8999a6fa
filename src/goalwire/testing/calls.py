"""Calls a service or an action from a test that is a plain function."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from goalwire.entities.actions.types import FeedbackT, GoalT, ResultT
from goalwire.errors import GoalwireError
from goalwire.execution.waiters import running_loop
from goalwire.records import record

if TYPE_CHECKING:
    from collections.abc import Coroutine

    from goalwire.aio import Node
    from goalwire.entities.actions.types import ActionClass
    from goalwire.entities.type_support import ServiceClass

T = TypeVar('T')
RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


@record
class Outcome(Generic[ResultT, FeedbackT]):
    """The outcome of a goal that succeeded."""

    result: ResultT
    feedback: list[FeedbackT]


def call(
    node: Node,
    srv_type: ServiceClass[RequestT, ResponseT],
    name: str,
    request: RequestT | None,
    timeout: float,
    fields: dict[str, Any],
) -> ResponseT:
    """Call a service; see Graph.call."""

    async def calling() -> ResponseT:
        async with node:
            return await node.client(srv_type, name).call(request, timeout=timeout, **fields)

    return run_here(calling())


def send_goal(
    node: Node,
    action_type: ActionClass[GoalT, ResultT, FeedbackT],
    name: str,
    goal: GoalT | None,
    timeout: float,
    fields: dict[str, Any],
) -> Outcome[ResultT, FeedbackT]:
    """Send a goal; see Graph.send_goal."""

    async def sending() -> Outcome[ResultT, FeedbackT]:
        async with (
            node,
            node.action(action_type, name).send(goal, timeout=timeout, **fields) as run,
        ):
            feedback = [message async for message in run.feedback]
            return Outcome(await run.result, feedback)

    return run_here(sending())


def run_here(coroutine: Coroutine[Any, Any, T]) -> T:
    """Run a coroutine on this thread; raises RuntimeError in an asyncio loop, which the call would block."""
    if running_loop() is not None:
        coroutine.close()
        raise RuntimeError(
            'this would hold up the asyncio loop that it is called in: use a client of graph.node(…) there'
        )
    try:
        return asyncio.run(coroutine)
    except GoalwireError as error:
        raise error.with_traceback(None) from None  # asyncio's frames do not help the test's author
