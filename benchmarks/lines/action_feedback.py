"""An action whose server sends a thousand feedback messages in a row, then the result."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of

if TYPE_CHECKING:
    from rclpy.action.server import ServerGoalHandle

MESSAGES = 1000
LINE = Line(
    f'action feedback, {MESSAGES} messages a goal',
    __name__,
    10,
    ('rate', 'arrived', 'cpu'),
    (
        Goal('rate', Of.REFERENCE, 8, 3, at_least=True),
        Goal('arrived', Of.ONE, 1, 1, at_least=True),
    ),
    {'rate': 8100, 'arrived': 1 / 6},
)
ACTION = 'bench_feedback'
LATE_S = 0.5
"""Feedback that comes this long after the last one, and after the result, is given up."""


def answer() -> None:
    import rclpy
    from rclpy.action import ActionServer

    from benchmarks.lines.fibonacci import Fibonacci

    def execute(goal: ServerGoalHandle) -> Any:
        feedback = Fibonacci.Feedback(sequence=[0, 1, 1, 2, 3, 5])
        for _ in range(MESSAGES):
            goal.publish_feedback(feedback)
        goal.succeed()
        return Fibonacci.Result(sequence=[0, 1])

    rclpy.init()
    node = rclpy.create_node('bench_server')
    server = ActionServer(node, Fibonacci, ACTION, execute)
    stage.serve(node)
    del server


class Reached(NamedTuple):
    """A goal that was reached: in how many seconds its last feedback came, and how many did."""

    seconds: float
    arrived: int


@contextmanager
def reaching() -> Iterator[Callable[[], Reached]]:
    """Yield what reaches one goal, in a client that has reached none yet, and an executor that has spun."""
    import rclpy
    from rclpy.action import ActionClient

    from benchmarks.lines.fibonacci import Fibonacci

    rclpy.init()
    node = rclpy.create_node('bench_client')
    client = ActionClient(node, Fibonacci, ACTION)
    assert client.wait_for_server(spinning.PATIENCE_S)
    spinning.spin_once(node, timeout_sec=0)

    def reach() -> Reached:
        arrivals: list[float] = []
        begun = perf_counter()
        accepted = client.send_goal_async(
            Fibonacci.Goal(order=1), feedback_callback=lambda _: arrivals.append(perf_counter())
        )
        spinning.spin_until_done(node, accepted)
        goal = accepted.result()
        assert goal is not None
        ended = goal.get_result_async()
        spinning.spin_until_done(node, ended)
        before = -1
        while before < len(arrivals) < MESSAGES:
            before = len(arrivals)
            spinning.spin_once(node, timeout_sec=LATE_S)
        return Reached(arrivals[-1] - begun if arrivals else 0.0, len(arrivals))

    yield reach
    client.destroy()
    node.destroy_node()
    rclpy.shutdown()


def ask(count: int) -> Figures:
    with stage.Partner('benchmarks.lines.action_feedback') as partner, reaching() as reach:
        reach()
        meter = stage.Meter(partner)
        reached = [reach() for _ in range(count)]
        arrived = sum(each.arrived for each in reached)
        return meter.read(max(arrived, 1)) | {
            'rate': arrived / sum(each.seconds for each in reached),
            'arrived': arrived / (count * MESSAGES),
        }


if __name__ == '__main__':
    stage.run(ask, answer)
