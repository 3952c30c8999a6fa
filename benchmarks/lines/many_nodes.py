"""Many nodes in several processes: until everybody knows everybody, and what knowing costs at rest.

Each node has ten entities: the nine that every node has, and a publisher or a subscription.
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
    looks=False,
    spins=False,
)
TOPIC = 'bench_everybody'
SETTLE_S, IDLE_S = 1.0, 3.0
LOOK_S = 0.02
"""How often a process looks whether it has found everybody: rclpy has no way to be told."""


def make(first: int, count: int) -> list[Node]:
    """Make nodes; those with even numbers publish what the others subscribe to."""
    import rclpy
    from std_msgs.msg import String

    nodes = []
    for number in range(first, first + count):
        node = rclpy.create_node(f'bench_{number}')
        if number % 2:
            node.create_subscription(String, TOPIC, print, 10)
        else:
            node.create_publisher(String, TOPIC, 10)
        nodes.append(node)
    return nodes


def find(node: Node, total: int) -> None:
    """Wait until every node and the entities of each are known here."""

    def all_known() -> bool:
        if len([name for name in node.get_node_names() if name.startswith('bench_')]) < total:
            return False
        if node.count_publishers(TOPIC) + node.count_subscribers(TOPIC) < total:
            return False
        return node.count_publishers('/rosout') >= total and all(
            node.count_services(f'/bench_{number}/{last}')
            for number in range(total)
            for last in ('get_type_description', 'set_parameters_atomically')
        )

    while not all_known():
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
        'make': lambda: nodes.extend(make(first, count)),
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
