"""Node.graph: who is there, what does not go together, and when that changes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest
from helpers.loops import Play
from helpers.patience import PATIENCE
from std_msgs.msg import Int64, String
from std_srvs.srv import SetBool

import goalwire
from goalwire.aio.graph import EndpointKind
from goalwire.errors import ClosedError

pytestmark = pytest.mark.also_on_dds


async def until(node: goalwire.Node, holds: Callable[[], bool]) -> None:
    """Wait for the graph to show something; its changes wake this."""
    with node.graph.changes() as changes:
        async with asyncio.timeout(PATIENCE):
            while not holds():
                await anext(changes)


def test_nodes_and_endpoints_are_shown_and_go(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('watcher') as watcher:
            graph = watcher.graph
            async with goalwire.Node('lamp', namespace='/hall') as lamp:
                lamp.service(SetBool, 'switch', lambda _request: SetBool.Response())
                lamp.publisher(String, 'state')
                await until(watcher, lambda: ('/hall/state', ['std_msgs/msg/String']) in graph.topics())
                await until(watcher, lambda: ('/hall/switch', ['std_srvs/srv/SetBool']) in graph.services())
                assert graph.nodes() == ['/hall/lamp', '/watcher']
                [publisher] = graph.publishers('/hall/state')
                assert (publisher.kind, publisher.node.qualified) == (EndpointKind.PUBLISHER, '/hall/lamp')
                assert publisher in graph.endpoints()
                before = graph.version
            await until(watcher, lambda: graph.nodes() == ['/watcher'])
            assert graph.version != before
        with pytest.raises(ClosedError):
            graph.nodes()

    play(scenario)


def test_a_service_that_is_only_called_is_not_served(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('caller') as caller:
            graph = caller.graph
            caller.client(SetBool, '/switch')
            await until(caller, lambda: ('/switch', ['std_srvs/srv/SetBool']) in graph.services())
            assert '/switch' not in dict(graph.served())
            async with goalwire.Node('lamp') as lamp:
                lamp.service(SetBool, '/switch', lambda _request: SetBool.Response())
                await until(caller, lambda: ('/switch', ['std_srvs/srv/SetBool']) in graph.served())
                assert [server.node.qualified for server in graph.servers('/switch')] == ['/lamp']
            await until(caller, lambda: not graph.servers('/switch'))
            assert '/switch' not in dict(graph.served())

    play(scenario)


def test_types_and_qos_that_do_not_go_together_are_told_once(play: Play) -> None:
    async def scenario() -> None:
        weak = goalwire.QoS(reliability=goalwire.ReliabilityPolicy.BEST_EFFORT)
        async with goalwire.Node('one') as one, goalwire.Node('other') as other:
            assert one.graph.problems() == []
            one.publisher(String, 'words')
            other.subscription(Int64, 'words')
            one.publisher(String, 'weak', qos=weak)
            other.subscription(String, 'weak')
            one.publisher(String, 'fine')
            other.subscription(String, 'fine')
            await until(one, lambda: len(one.graph.problems()) == 2)
            problems = {problem.name: problem for problem in one.graph.problems()}
            assert set(problems) == {'/words', '/weak'}
            assert 'std_msgs/msg/Int64' in problems['/words'].text
            assert 'best effort' in problems['/weak'].text.lower()
            assert {each.node.qualified for each in problems['/weak'].endpoints} == {'/one', '/other'}

    play(scenario)


def test_changes_end_when_they_are_closed(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('watcher') as watcher:
            changes = watcher.graph.changes()
            watcher.publisher(String, 'state')
            async with asyncio.timeout(PATIENCE):
                assert await anext(changes) <= watcher.graph.version
            changes.close()
            changes.close()
            assert [version async for version in changes if version < 0] == []

    play(scenario)
