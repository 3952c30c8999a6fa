"""`gw_expect`: a bag as a regression test, in virtual time."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from example_interfaces.action import Fibonacci
from std_srvs.srv import SetBool

from goalwire.apps.bag.recorder import Recorder
from goalwire.apps.bag.selection import Names, Selection
from goalwire.rosbag2.writer import Writer
from goalwire.testing import Expect, Graph, VirtualClock

STEPS = [Fibonacci.Feedback(sequence=[length]) for length in range(3)]
CALLS = Selection(Names(), Names(all=True), Names(all=True))


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A call, and ten minutes later a goal, which takes a minute."""

    async def record(graph: Graph) -> None:
        async with (
            graph.node('caller') as caller,
            graph.node('recorder') as node,
            Recorder(node, Writer(tmp_path / 'bag'), CALLS) as recorder,
        ):
            while len(recorder.topics) < 6:  # noqa: ASYNC110 - nothing tells of it
                await asyncio.sleep(0.1)
            await asyncio.sleep(1.0)
            await caller.client(SetBool, 'set').call(data=True)
            await asyncio.sleep(600.0)
            await caller.action(Fibonacci, 'count').call(order=3)
            await asyncio.sleep(1.0)

    with VirtualClock(), Graph() as graph:
        serve(graph)
        asyncio.run(record(graph))
    return tmp_path / 'bag'


def serve(graph: Graph, message: str = 'done', last: int = 3) -> None:
    graph.service(SetBool, 'set', SetBool.Response(success=True, message=message))
    graph.action(
        Fibonacci, 'count', feedback=STEPS, every=20.0, result=Fibonacci.Result(sequence=[1, 2, last])
    )


def test_servers_that_answer_as_recorded_pass(
    bag: Path, gw_clock: VirtualClock, gw_graph: Graph, gw_expect: Expect
) -> None:
    serve(gw_graph)
    gw_expect(bag)
    assert 660 <= gw_clock.elapsed < 665


def test_each_field_that_differs_is_a_line_of_the_failure(
    bag: Path, gw_clock: VirtualClock, gw_graph: Graph, gw_expect: Expect
) -> None:
    serve(gw_graph, message='DONE', last=4)
    with pytest.raises(AssertionError) as failure:
        gw_expect(bag)
    assert str(failure.value).splitlines() == [
        "call 1 '/set' (data=True): message 'DONE', was 'done'",
        "goal 2 '/count' (order=3): result.sequence[2] 4, was 3",
    ]
    gw_expect(bag, ignore_fields=('message', 'result.sequence'))
