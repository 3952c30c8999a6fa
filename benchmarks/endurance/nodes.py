"""Nodes that are made and destroyed: what their process holds after a tenth, and another that looks on.

Each has a publisher, a subscription and a service, beside the nine entities that every node has.
"""

from __future__ import annotations

import gc
import os
from time import monotonic, process_time, sleep

from benchmarks import spinning, stage
from benchmarks.endurance.held import Held
from benchmarks.line import Figures

PARTS = 10


def answer() -> None:
    import rclpy

    rclpy.init()
    node = rclpy.create_node('endurance_onlooker')
    stage.obey({'nodes': lambda: len(node.get_node_names()), 'collect': gc.collect})
    rclpy.shutdown()


def churn(number: int) -> float:
    """Make and destroy nodes; return how much processor time that took here."""
    import rclpy
    from example_interfaces.srv import AddTwoInts
    from std_msgs.msg import String

    before = process_time()
    for each in range(number):
        node = rclpy.create_node(f'endurance_{each % 100}')
        node.create_publisher(String, 'topic', 10)
        node.create_subscription(String, 'topic', print, 10)
        node.create_service(AddTwoInts, 'service', lambda _, response: response)
        node.destroy_node()
    gc.collect()
    return process_time() - before


def ask(count: int) -> Figures:
    import rclpy

    with stage.Partner('benchmarks.endurance.nodes') as partner:
        rclpy.init()
        churn(count // PARTS)
        partner.do('collect')
        held = Held(maker=os.getpid(), onlooker=partner.pid)
        times = [churn(count // PARTS) for _ in range(PARTS - 1)]
        end = monotonic() + spinning.PATIENCE_S
        while (left := partner.do('nodes') - 1) and monotonic() < end:
            sleep(0.05)
        partner.do('collect')
        figures = held.since() | {
            'nodes left': left,
            'first ninth CPU s': times[0],
            'last ninth CPU s': times[-1],
        }
        rclpy.shutdown()
        return figures


if __name__ == '__main__':
    stage.run(ask, answer)
