"""Calls and goals are recorded without introspection, as goalwire's servers and clients tell them."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from helpers.loops import Play
from helpers.patience import PATIENCE

import goalwire
from goalwire.apps.bag.recorder import Recorder
from goalwire.apps.bag.selection import Names, Selection
from goalwire.entities.recorder_watch import POSTFIX_FOR_RECORDERS, SWITCH
from goalwire.entities.service_introspection import ServiceIntrospectionState
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind

CALLS = Selection(Names(), Names(all=True), Names(all=True))
SENT, RECEIVED, ANSWERED, CAME = range(4)


async def add(request: AddTwoInts.Request) -> AddTwoInts.Response:
    return AddTwoInts.Response(sum=request.a + request.b)


async def count(goal: Any) -> Fibonacci.Result:
    for length in range(1, goal.request.order + 1):
        goal.feedback(sequence=list(range(length)))
    return Fibonacci.Result(sequence=list(range(goal.request.order)))


async def until(node: goalwire.Node, condition: Callable[[], object]) -> None:
    """Wait for a state of the graph."""
    async with asyncio.timeout(PATIENCE):
        with node.graph.changes() as changes:
            while not condition():
                await anext(changes)


@asynccontextmanager
async def recording(path: Path) -> AsyncIterator[Recorder]:
    async with goalwire.Node('recorder') as node, Recorder(node, Writer(path), CALLS) as recorder:
        yield recorder


def publishers(node: goalwire.Node, name: str) -> int:
    return sum(e.kind is EndpointKind.PUBLISHER and e.name == name for e in node.graph.endpoints())


async def until_asked(*entities: Any) -> None:
    """Wait until servers and clients tell a recorder of their calls."""
    parts: list[Any] = []
    for entity in entities:
        core = entity._core
        if hasattr(core, '_endpoints'):
            parts += core._endpoints.servers
        elif hasattr(core, 'goal_requests'):
            parts += core.goal_requests, core.cancel_requests, core.result_requests
        else:
            parts.append(core)
    async with asyncio.timeout(PATIENCE):
        while not all(part.recorded for part in parts):  # noqa: ASYNC110 - nothing tells of it
            await asyncio.sleep(0.005)


async def until_recorded(recorder: Recorder, messages: int) -> None:
    async with asyncio.timeout(PATIENCE):
        while recorder.count < messages:  # noqa: ASYNC110 - nothing tells of it
            await asyncio.sleep(0.005)


def events(path: Path, topic: str) -> list[Any]:
    with Reader(path) as bag:
        return [event for _, event in bag.decoded([topic])]


@pytest.mark.also_on_dds
def test_a_call_is_recorded_from_both_sides(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('server') as server, goalwire.Node('caller') as caller:
            service = server.service(AddTwoInts, 'add', add)
            client = caller.client(AddTwoInts, 'add')
            async with recording(tmp_path / 'bag') as recorder:
                await until_asked(service, client)
                await client.call(a=2, b=40, timeout=PATIENCE)
                await until_recorded(recorder, 4)
                assert recorder.topics == ['/add/_service_event']
            await until(caller, lambda: publishers(caller, '/add' + POSTFIX_FOR_RECORDERS) == 0)

    play(scenario)
    found = events(tmp_path / 'bag', '/add/_service_event')
    assert sorted(event.info.event_type for event in found) == [SENT, RECEIVED, ANSWERED, CAME]
    assert len({(bytes(e.info.client_gid), e.info.sequence_number) for e in found}) == 1
    assert [e.request[0].b for e in found if e.request] == [40, 40]
    assert [e.response[0].sum for e in found if e.response] == [42, 42]


@pytest.mark.also_on_dds
def test_a_goal_is_recorded_whole(play: Play, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with goalwire.Node('server') as server, goalwire.Node('caller') as caller:
            action = server.action_server(Fibonacci, 'count', count)
            client = caller.action(Fibonacci, 'count')
            async with recording(tmp_path / 'bag') as recorder:
                await until_asked(action, client)
                await client.call(order=3, timeout=PATIENCE)
                await client.cancel_all_goals(timeout=PATIENCE)
                await until_recorded(recorder, 3 * 4 + 3 + 2)

    play(scenario)
    bag = tmp_path / 'bag'
    goals = events(bag, '/count/_action/send_goal/_service_event')
    results = events(bag, '/count/_action/get_result/_service_event')
    cancels = events(bag, '/count/_action/cancel_goal/_service_event')
    feedback = events(bag, '/count/_action/feedback')
    for steps in (goals, results, cancels):
        assert sorted(event.info.event_type for event in steps) == [SENT, RECEIVED, ANSWERED, CAME]
    assert {event.request[0].goal.order for event in goals if event.request} == {3}
    assert {event.response[0].accepted for event in goals if event.response} == {True}
    assert {tuple(e.response[0].result.sequence) for e in results if e.response} == {(0, 1, 2)}
    assert {e.response[0].status for e in results if e.response} == {GoalStatus.STATUS_SUCCEEDED}
    assert [len(message.feedback.sequence) for message in feedback] == [1, 2, 3]
    assert events(bag, '/count/_action/status')


def test_services_that_every_node_has_are_recorded_if_they_are_named(play: Play, tmp_path: Path) -> None:
    named = Selection(services=Names(some=frozenset({'/server/list_parameters', '/add'})))
    calls = {}

    async def scenario() -> None:
        async with goalwire.Node('server') as server, goalwire.Node('recorder') as node:
            server.service(AddTwoInts, 'add', add)
            for title, selection in (('all', CALLS), ('named', named)):
                async with Recorder(node, Writer(tmp_path / title), selection) as recorder:
                    await until(server, lambda: publishers(server, '/add' + POSTFIX_FOR_RECORDERS) == 1)
                    calls[title] = set(recorder.topics)
                await until(server, lambda: publishers(server, '/add' + POSTFIX_FOR_RECORDERS) == 0)

    play(scenario)
    assert calls['all'] == {'/add/_service_event'}
    assert calls['named'] == {'/server/list_parameters/_service_event', '/add/_service_event'}


def test_what_a_program_has_switched_on_comes_first(play: Play, tmp_path: Path) -> None:
    """A program that shows who calls, and hides what is said, is not asked for more."""

    async def scenario() -> None:
        async with goalwire.Node('server') as server, goalwire.Node('caller') as caller:
            service = server.service(AddTwoInts, 'add', add)
            service._core.introspect(server.clock, QoS(), ServiceIntrospectionState.METADATA)
            client = caller.client(AddTwoInts, 'add')
            async with recording(tmp_path / 'bag') as recorder:
                await until_asked(service, client)
                await client.call(a=1, b=1, timeout=PATIENCE)
                await until_recorded(recorder, 4)

    play(scenario)
    found = {event.info.event_type: event for event in events(tmp_path / 'bag', '/add/_service_event')}
    assert not found[RECEIVED].request
    assert not found[ANSWERED].response
    assert found[SENT].request


def test_a_variable_keeps_calls_to_the_program(
    play: Play, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> None:
        async with goalwire.Node('caller') as caller, recording(tmp_path / 'bag') as recorder:
            client = caller.client(AddTwoInts, 'add')  # the variable is read when it is made
            monkeypatch.setenv(SWITCH, 'off')
            async with goalwire.Node('server') as server:
                server.service(AddTwoInts, 'add', add)
                await until_asked(client)
                await client.call(a=1, b=1, timeout=PATIENCE)
                await until_recorded(recorder, 2)

    play(scenario)
    assert [e.info.event_type for e in events(tmp_path / 'bag', '/add/_service_event')] == [SENT, CAME]
