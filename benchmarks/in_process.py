"""The cost of goalwire within one process, and a yardstick of plain Python beside it: best of several, µs.

usage: RMW_IMPLEMENTATION=goalwire_memory python -m benchmarks.in_process ask REPEATS
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from itertools import repeat
from time import thread_time

from benchmarks import stage
from benchmarks.line import Figures

PACK = struct.Struct('<IiI7d').pack


def yardstick() -> object:
    """Do what any Python program does: make objects, look things up, pack numbers."""
    total = 0
    names = {}
    for number in range(20):
        names[f'joint_{number}'] = (number, number * 0.5)
        total += len(PACK(number, number, 4, *repeat(0.5, 7)))
    return total, sorted(names)


def best(action: Callable[[], object], number: int) -> float:
    """Return the µs of one call, the best of three runs."""
    runs = []
    for _ in range(3):
        begun = thread_time()
        for _ in range(number):
            action()
        runs.append((thread_time() - begun) / number)
    return min(runs) * 1e6


def ask(repeats: int) -> Figures:
    import rclpy
    from geometry_msgs.msg import PoseStamped
    from rclpy.serialization import deserialize_message, serialize_message
    from std_srvs.srv import SetBool

    rclpy.init()
    node = rclpy.create_node('bench_local')
    node.create_service(SetBool, 'bench_local', lambda _, response: response)
    client = node.create_client(SetBool, 'bench_local')
    request, pose, received = SetBool.Request(), PoseStamped(), list[PoseStamped]()
    pose.header.frame_id = 'map'
    data = serialize_message(pose)
    publisher = node.create_publisher(PoseStamped, 'bench_local', 10)
    node.create_subscription(PoseStamped, 'bench_local', received.append, 10)

    def call() -> None:
        rclpy.spin_until_future_complete(node, client.call_async(request))

    def topic() -> None:
        publisher.publish(pose)
        rclpy.spin_once(node)

    works: dict[str, tuple[Callable[[], object], int]] = {
        'yardstick': (yardstick, 1000),
        'call': (call, 300),
        'topic': (topic, 300),
        'encode': (lambda: serialize_message(pose), 5000),
        'decode': (lambda: deserialize_message(data, PoseStamped), 3000),
        'new': (PoseStamped, 2000),
    }
    figures: Figures = {}
    for _ in range(repeats):
        for name, (action, number) in works.items():
            figures[name] = min(best(action, number), figures.get(name, float('inf')))
    assert received
    node.destroy_node()
    rclpy.shutdown()
    return figures


if __name__ == '__main__':
    stage.run(ask, lambda: None)
