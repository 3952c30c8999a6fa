"""An action whose server sends a thousand feedback messages in a row, then the result."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING, Any

from benchmarks import stage
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
        Goal('rate', Of.REFERENCE, 3, 3, at_least=True),
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


def ask(count: int) -> Figures:
    import rclpy
    from rclpy.action import ActionClient

    from benchmarks.lines.fibonacci import Fibonacci

    with stage.Partner('benchmarks.lines.action_feedback') as partner:
        rclpy.init()
        node = rclpy.create_node('bench_client')
        client = ActionClient(node, Fibonacci, ACTION)
        assert client.wait_for_server(stage.PATIENCE_S)
        arrivals: list[float] = []

        def reach() -> float:
            """Return seconds from the goal to its last feedback."""
            arrivals.clear()
            begun = perf_counter()
            accepted = client.send_goal_async(
                Fibonacci.Goal(order=1), feedback_callback=lambda _: arrivals.append(perf_counter())
            )
            stage.spin_until_done(node, accepted)
            goal = accepted.result()
            assert goal is not None
            ended = goal.get_result_async()
            stage.spin_until_done(node, ended)
            before = -1
            while before < len(arrivals) < MESSAGES:
                before = len(arrivals)
                rclpy.spin_once(node, timeout_sec=LATE_S)
            return arrivals[-1] - begun if arrivals else 0.0

        reach()
        meter = stage.Meter(partner)
        taken, arrived = 0.0, 0
        for _ in range(count):
            taken += reach()
            arrived += len(arrivals)
        figures = meter.read(max(arrived, 1))
        client.destroy()
        node.destroy_node()
        rclpy.shutdown()
        return figures | {'rate': arrived / taken, 'arrived': arrived / (count * MESSAGES)}


if __name__ == '__main__':
    stage.run(ask, answer)
