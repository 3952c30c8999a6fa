"""Thousands of publishers in each of two processes: both see all, and nothing of one that is killed."""

from __future__ import annotations

import os
import signal
import sys
from time import monotonic, sleep
from typing import TYPE_CHECKING

from benchmarks import stage
from benchmarks.endurance.held import Held, peak_mib
from benchmarks.line import Figures

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.qos import QoSProfile

SIDES = ('north', 'south')
PATIENCE_S = 120.0


def quality(number: int) -> QoSProfile:
    """Return the QoS of a publisher: each of several kinds, and depths that differ."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    return QoSProfile(
        depth=1 + number % 50,
        reliability=ReliabilityPolicy.RELIABLE if number % 2 else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if number % 3 == 0 else DurabilityPolicy.VOLATILE,
    )


def answer(side: int, count: int) -> None:
    import rclpy
    from std_msgs.msg import String

    rclpy.init()
    node = rclpy.create_node(SIDES[side])
    other = SIDES[1 - side]

    def make() -> None:
        for number in range(count):
            node.create_publisher(String, f'/{SIDES[side]}/topic_{number}', quality(number))

    stage.obey({
        'make': make,
        'seen': lambda: _seen(node, other),
        'right': lambda: sum(_is_right(node, other, number) for number in range(count)),
    })  # fmt: skip


def _seen(node: Node, other: str) -> int:
    """How many publishers of the other side are seen, those of every node left out."""
    return sum(
        node.count_publishers(name)
        for name, _ in node.get_topic_names_and_types()
        if name.startswith(f'/{other}/')
    )


def _is_right(node: Node, other: str, number: int) -> bool:
    """Whether exactly one publisher of a topic is seen, with its node's name, type and QoS."""
    found = node.get_publishers_info_by_topic(f'/{other}/topic_{number}')
    if len(found) != 1:
        return False
    (there,) = found
    wanted, seen = quality(number), there.qos_profile
    return (
        (there.node_name, there.node_namespace) == (other, '/')
        and there.topic_type == 'std_msgs/msg/String'
        and seen.reliability == wanted.reliability
        and seen.durability == wanted.durability
        and seen.depth == wanted.depth
    )


def ask(count: int) -> Figures:
    with (
        stage.Partner('benchmarks.endurance.publishers', 0, count) as north,
        stage.Partner('benchmarks.endurance.publishers', 1, count) as south,
    ):
        held = Held(north=north.pid)
        watch = stage.Stopwatch()
        for side in (north, south):
            side.order('make')
        for side in (north, south):
            side.result()
        made = watch.read()
        for side in (north, south):
            _wait_for(side, count)
        known = watch.read()
        right = [side.do('right') for side in (north, south)]
        peak = peak_mib(north.pid)
        os.kill(south.pid, signal.SIGKILL)
        watch = stage.Stopwatch()
        _wait_for(north, 0)
        return held.since() | {
            'made s': made,
            'known s': known,
            'north sees rightly': right[0],
            'south sees rightly': right[1],
            'gone s': watch.read(),
            'north MiB at most': peak,
        }


def _wait_for(side: stage.Partner, number: int) -> None:
    """Wait until a side sees exactly so many publishers of the other."""
    deadline = monotonic() + PATIENCE_S
    while (seen := side.do('seen')) != number:
        if monotonic() > deadline:
            sys.exit(f'{seen:g} publishers are seen, not {number}')
        sleep(0.05)


if __name__ == '__main__':
    stage.run(ask, answer)
