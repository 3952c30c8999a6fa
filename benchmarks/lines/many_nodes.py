"""Many nodes in several processes: until everybody knows everybody, and what knowing costs at rest.

Each node has four publishers, four subscriptions, a service and a client, besides what every node has.
"""

from __future__ import annotations

from contextlib import ExitStack
from time import process_time, sleep
from typing import TYPE_CHECKING

from benchmarks import stage
from benchmarks.line import Figures, Goal, Line, Of

if TYPE_CHECKING:
    from rclpy.node import Node

NODES = 200
PROCESSES = 8
LINE = Line(
    f'{NODES} nodes, {NODES * 10} entities in {PROCESSES} processes',
    __name__,
    NODES,
    ('found', 'idle'),
    (
        Goal('found', Of.ONE, 2, 5),
        Goal('idle', Of.ONE, 1, 1),
    ),
    rounds=2,
)
ALL = 'bench_everybody'
SETTLE_S, IDLE_S = 1.0, 3.0
LOOK_S = 0.02
"""How often a process looks whether it has found everybody: rclpy has no way to be told."""


def make(first: int, count: int, total: int) -> list[Node]:
    """Make nodes whose topics are read by the next one's subscriptions."""
    import rclpy
    from std_msgs.msg import String
    from std_srvs.srv import SetBool

    nodes = []
    for number in range(first, first + count):
        node, last = rclpy.create_node(f'bench_{number}'), (number - 1) % total
        for topic in (f'bench_out_{number}', f'bench_state_{number}', ALL, f'bench_log_{number}'):
            node.create_publisher(String, topic, 10)
        for topic in (f'bench_out_{last}', f'bench_state_{last}', ALL, f'bench_in_{number}'):
            node.create_subscription(String, topic, print, 10)
        node.create_service(SetBool, f'bench_serve_{number}', lambda _, response: response)
        node.create_client(SetBool, f'bench_serve_{last}')
        nodes.append(node)
    return nodes


def find(node: Node, total: int) -> None:
    """Wait until every node and every endpoint of them is known here."""

    def ends() -> bool:
        if len([name for name in node.get_node_names() if name.startswith('bench_')]) < total:
            return False
        return node.count_publishers(ALL) == node.count_subscribers(ALL) == total and all(
            node.count_publishers(f'bench_log_{number}') and node.count_services(f'bench_serve_{number}')
            for number in range(total)
        )

    while not ends():
        sleep(LOOK_S)


def rest(nodes: list[Node]) -> float:
    """Spin a while and return the CPU that took, in percent."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    executor = SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)
    never: rclpy.Future[None] = rclpy.Future()
    executor.spin_until_future_complete(never, timeout_sec=SETTLE_S)
    before = process_time()
    executor.spin_until_future_complete(never, timeout_sec=IDLE_S)
    return (process_time() - before) / IDLE_S * 100


def answer(first: int, count: int, total: int) -> None:
    import rclpy

    rclpy.init()
    nodes: list[Node] = []
    stage.obey({
        'make': lambda: nodes.extend(make(first, count, total)),
        'find': lambda: find(nodes[0], total),
        'rest': lambda: rest(nodes),
    })  # fmt: skip
    rclpy.shutdown()


def measure(total: int, processes: int) -> Figures:
    share = max(total // processes, 1)
    total = share * processes
    with ExitStack() as stack:
        partners = [
            stack.enter_context(stage.Partner('benchmarks.lines.many_nodes', index * share, share, total))
            for index in range(processes)
        ]
        everybody = _Everybody(partners)
        watch = stage.Stopwatch()
        everybody.do('make')
        made = watch.read()
        everybody.do('find')
        found = watch.read()
        return {'found': found, 'made': made, 'idle': sum(everybody.do('rest')) / processes}


class _Everybody:
    def __init__(self, partners: list[stage.Partner]) -> None:
        self._partners = partners

    def do(self, command: str) -> list[float]:
        for partner in self._partners:
            partner.order(command)
        return [partner.result() for partner in self._partners]


def ask(total: int) -> Figures:
    return measure(total, PROCESSES)


if __name__ == '__main__':
    stage.run(ask, answer)
