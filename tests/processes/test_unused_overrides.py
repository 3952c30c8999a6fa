"""A program whose parameters nobody used says so when it ends, in both fronts."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.fresh import run_python

RCLPY = """\
    import rclpy, sys
    from rclpy.node import Node
    rclpy.init(args=sys.argv)
    other = Node('helper', use_global_arguments=False)  # takes no arguments, so it cannot use them
    other.declare_parameter('spedd', 0)
    robot = Node('robot')
    robot.declare_parameter('speed', 1.0)
    robot.destroy_node()
    rclpy.shutdown()
"""
AIO = """\
    import asyncio, sys, goalwire
    async def main():
        async with goalwire.Node('robot') as node:
            node.parameters.declare('speed', 1.0)
    asyncio.run(main())
"""


@pytest.mark.parametrize('program', [RCLPY, AIO], ids=['rclpy', 'asyncio'])
def test_an_override_that_nothing_declared_is_one_warning_at_the_end(program: str, tmp_path: Path) -> None:
    arguments = ('prog', '--ros-args', '-p', 'spedd:=2.0', '-p', 'speed:=3.0', '-p', 'robto:speed:=4.0')
    done = run_python(program, *arguments, cwd=tmp_path, RMW_IMPLEMENTATION='goalwire_memory')
    assert done.returncode == 0, done.stderr
    said = [
        line.partition(': ')[2] for line in (done.stdout + done.stderr).splitlines() if 'nothing used' in line
    ]
    assert said == [
        "nothing used '-p spedd:=…': /robot did not declare spedd; did you mean speed?",
        "nothing used '-p robto:speed:=…': there was no node /robto; this program made /robot",
    ]


STOPPED = """\
    import os, rclpy, signal, sys
    rclpy.init(args=sys.argv)
    node = rclpy.create_node('robot')
    node.declare_parameter('speed', 1.0)
    node.create_timer(0.01, lambda: os.kill(os.getpid(), signal.SIGINT))
    rclpy.spin(node)
"""


def test_ctrl_c_tells_what_is_misspelt_and_not_what_a_launch_file_gives_to_all(tmp_path: Path) -> None:
    arguments = ('prog', '--ros-args', '-p', 'spedd:=2.0', '-p', 'colour:=red')
    done = run_python(STOPPED, *arguments, cwd=tmp_path, RMW_IMPLEMENTATION='goalwire_memory')
    said = [line.partition(': ')[2] for line in done.stderr.splitlines() if 'nothing used' in line]
    assert said == ["nothing used '-p spedd:=…': /robot did not declare spedd; did you mean speed?"]
