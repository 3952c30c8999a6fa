"""Programs of rclpy and of asyncio, run in a thread of the test."""

from __future__ import annotations

import asyncio
import sys
import time

import pytest
import rclpy
from std_srvs.srv import SetBool

import goalwire
from goalwire.testing import Graph, VirtualClock


def test_a_program_runs_with_its_arguments_until_the_end_of_the_block(clock: VirtualClock) -> None:
    ended = []

    def main() -> None:
        rclpy.init()
        try:
            rclpy.spin(rclpy.create_node('worker'))
        except rclpy.executors.ExternalShutdownException:
            ended.append(True)

    before = sys.argv
    with Graph() as graph:
        program = graph.run(main, '--ros-args', '-r', '__node:=renamed', node='renamed')
        running = [program.running]
        assert sys.argv == [program.name, '--ros-args', '-r', '__node:=renamed']
    running.append(program.running)
    assert running == [True, False]
    assert sys.argv is before
    assert ended == [True]


def test_a_program_that_ends_tells_what_it_returned_or_raised(graph: Graph) -> None:
    def leave() -> None:
        time.sleep(1.0)
        raise SystemExit(3)

    def fail() -> None:
        raise ValueError('boom')

    assert graph.run(lambda: 'done').wait() == 'done'
    assert graph.run(leave).wait() == 3
    with pytest.raises(ValueError, match='boom'):
        graph.run(fail).wait()
    slow = graph.run(lambda: time.sleep(20.0))
    with pytest.raises(AssertionError, match='did not end within 10 s'):
        slow.wait(timeout=10.0)
    slow.wait(timeout=20.0)


def test_a_program_of_asyncio_is_cancelled_at_the_end(clock: VirtualClock) -> None:
    cleaned_up = []

    async def main() -> None:
        async with goalwire.Node('worker') as node:
            node.service(SetBool, 'set', lambda _: SetBool.Response(success=True))
            try:
                await asyncio.Event().wait()
            finally:
                cleaned_up.append(True)

    with Graph() as graph:
        graph.run(main, node='worker')
        assert graph.call(SetBool, 'set').success
    assert cleaned_up == [True]
