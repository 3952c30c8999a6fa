"""Stops and releases robots, and reports how each service answered."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypeAlias

import goalwire
from goalwire.errors import peer_text
from goalwire.observe.messages import interface_class
from goalwire.records import record

if TYPE_CHECKING:
    from goalwire.apps.console.state.vitals import Vitals
    from goalwire.observe.emergency_stops import StopService

CONFIRMED_S = 1.0
"""Seconds after which a stop without an answer is shown as unconfirmed."""
ANSWER_S = 10.0
"""Seconds to wait for a late answer, which is reported as late."""
_TEXT = 300


@record
class Answer:
    """The outcome of one call of one robot's emergency stop."""

    robot: str
    service: str
    text: str
    is_done: bool
    """True if the server did as asked."""


Listener: TypeAlias = Callable[[Answer], object]


async def stop(node: goalwire.Node, robots: Sequence[Vitals], tell: Listener) -> None:
    """Call the emergency stops of robots, all at once, and report each answer when it comes.

    A service that seems to have no server is called, too, because the graph may be out of date.
    """
    calls = []
    for robot in robots:
        if not robot.emergency.known:
            tell(Answer(robot.namespace, '', 'it has no emergency stop that could be called', is_done=False))
        calls += [_stop(node, robot, service, tell) for service in robot.emergency.known]
    await asyncio.gather(*calls)


async def _stop(node: goalwire.Node, robot: Vitals, service: StopService, tell: Listener) -> None:
    began = perf_counter()
    if service not in robot.emergency.servers:
        text = 'no server of it is there'
        tell(Answer(robot.namespace, service.name, text, is_done=False))
    answer = await _call(node, robot.namespace, service, service.values, 'stopped')
    if answer.is_done:
        left = CONFIRMED_S - (perf_counter() - began)
        if not await robot.says_stopped(max(left, CONFIRMED_S / 4)):
            text = f'{answer.text}, but the robot says that it is not stopped'
            answer = Answer(robot.namespace, service.name, text, is_done=False)
    tell(answer)


async def release(node: goalwire.Node, robot: Vitals) -> list[Answer]:
    """Call the services that release a robot; return how each answered."""
    calls = [
        _call(node, robot.namespace, service, {'data': False}, 'released')
        for service in robot.emergency.can_release
    ]
    return list(await asyncio.gather(*calls))


async def _call(
    node: goalwire.Node, robot: str, service: StopService, values: dict[str, bool], done: str
) -> Answer:
    """Call a service and return its answer. An invalid name, which a peer may announce, gives a failure."""
    began = perf_counter()
    try:
        answer = await _answer(node, service, values)
    except goalwire.GoalwireError as error:
        text = peer_text(f'{type(error).__name__}: {error}', _TEXT)
        return Answer(robot, service.name, text, is_done=False)
    took = f'after {perf_counter() - began:.2f} s'
    said = peer_text(getattr(answer, 'message', ''), _TEXT)
    if not getattr(answer, 'success', True):
        return Answer(robot, service.name, f'refused {took}: {said}', is_done=False)
    extra = f': {said}' if said not in {'', done} else ''
    return Answer(robot, service.name, f'{done} {took}{extra}', is_done=True)


async def _answer(node: goalwire.Node, service: StopService, values: dict[str, bool]) -> Any:
    """Call a service with a new client, because the robot's report names the calling client."""
    cls = interface_class(service.type_name)
    client = node.client(cls, service.name)
    try:
        return await client.call(cls.Request(**values), timeout=ANSWER_S)
    finally:
        client.close()
