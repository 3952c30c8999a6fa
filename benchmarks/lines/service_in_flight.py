"""Calls of one client with 32 of them always on their way; those that are never answered are counted."""

from __future__ import annotations

from itertools import repeat
from time import perf_counter
from typing import TYPE_CHECKING, Any

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of
from benchmarks.lines.service_name import SERVICE
from benchmarks.lines.service_spin import answer

if TYPE_CHECKING:
    from rclpy.client import Client
    from rclpy.executors import Executor
    from rclpy.node import Node
    from rclpy.task import Future

WINDOW = 32
GIVE_UP_S = 1.0
"""A second without any reply: what is still missing is lost."""

LINE = Line(
    f'{WINDOW} calls in flight',
    __name__,
    6000,
    ('rate', 'lost', 'cpu'),
    (
        Goal('rate', Of.ONE, 30_000, 25_000, at_least=True),
        Goal('lost', Of.ONE, 0, 0),
    ),
    {'rate': 5700, 'lost': 22 / 3000 * 6000},
)


class Flight:
    """`count` calls in all, spread over the clients, `window` of them at a time."""

    def __init__(self, clients: list[Client[Any, Any]], window: int, count: int) -> None:
        from rclpy.task import Future
        from std_srvs.srv import SetBool

        self.answered = 0
        self.done: Future[None] = Future()
        self.last = 0.0
        self._count = count
        self._unsent = iter(repeat(None, count))
        self._request = SetBool.Request(data=True)
        for index in range(window):
            self._send(clients[index % len(clients)])

    def _send(self, client: Client[Any, Any]) -> None:
        for _ in self._unsent:
            future = client.call_async(self._request)
            future.add_done_callback(lambda done: self._next(client, done))
            return

    def _next(self, client: Client[Any, Any], future: Future[Any]) -> None:
        answer = future.result()
        assert answer is not None
        assert answer.success
        self.answered += 1
        self.last = perf_counter()
        if self.answered == self._count:
            self.done.set_result(None)
        else:
            self._send(client)

    def spin(self, node: Node, executor: Executor | None = None) -> None:
        """Spin until every call is answered, or none has been for a while."""
        before = -1
        while not self.done.done() and self.answered > before:
            before = self.answered
            if executor is None:
                spinning.spin_until_done(node, self.done, GIVE_UP_S)
            else:
                executor.spin_until_future_complete(self.done, GIVE_UP_S)


def measure(clients: int, window: int, count: int, *, has_nodes: bool = False) -> Figures:
    """Return calls a second, those lost, and CPU; `has_nodes`: each client has a node of its own."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from std_srvs.srv import SetBool

    with stage.Partner('benchmarks.lines.service_spin') as partner:
        rclpy.init()
        executor = SingleThreadedExecutor() if has_nodes else None
        nodes = [rclpy.create_node(f'bench_client_{number}') for number in range(clients if has_nodes else 1)]
        if executor is not None:
            for each in nodes:
                executor.add_node(each)
        node = nodes[0]
        ends = [nodes[number % len(nodes)].create_client(SetBool, SERVICE) for number in range(clients)]
        for end in ends:
            assert end.wait_for_service(spinning.PATIENCE_S)
        Flight(ends, window, 10 * window).spin(node, executor)
        meter = stage.Meter(partner)
        begun = perf_counter()
        flight = Flight(ends, window, count)
        flight.spin(node, executor)
        figures = meter.read(count) | {
            'rate': flight.answered / (flight.last - begun),
            'lost': count - flight.answered,
        }
        for each in nodes:
            each.destroy_node()
        rclpy.shutdown()
        return figures


def ask(count: int) -> Figures:
    return measure(1, WINDOW, count)


if __name__ == '__main__':
    stage.run(ask, answer)
