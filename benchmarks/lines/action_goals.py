"""An action, from sending a goal to its result, one goal after the other: does the thousandth cost more?"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of

if TYPE_CHECKING:
    from rclpy.action.server import ServerGoalHandle

LINE = Line(
    'action, goal to result, after 200 goals',
    __name__,
    500,
    ('p50', 'p99', 'growth', 'cpu'),
    (
        Goal('p50', Of.REFERENCE, 0.15, 0.2),
        Goal('growth', Of.ONE, 1.15, 1.15),
    ),
    {'p50': 3200},
)
ACTION = 'bench_count'
GROUP = 100
"""Goals whose median is compared: the first hundred and the last."""


def answer() -> None:
    import rclpy
    from rclpy.action import ActionServer

    from benchmarks.lines.fibonacci import Fibonacci

    def execute(goal: ServerGoalHandle) -> Any:
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

    with stage.Partner('benchmarks.lines.action_goals') as partner:
        rclpy.init()
        node = rclpy.create_node('bench_client')
        client = ActionClient(node, Fibonacci, ACTION)
        assert client.wait_for_server(spinning.PATIENCE_S)

        def reach() -> None:
            accepted = client.send_goal_async(Fibonacci.Goal(order=1))
            spinning.spin_until_done(node, accepted)
            goal = accepted.result()
            assert goal is not None
            ended = goal.get_result_async()
            spinning.spin_until_done(node, ended)
            outcome = ended.result()
            assert outcome is not None
            assert len(outcome.result.sequence) == 2

        first = stage.round_trips(reach, GROUP, partner)
        middle = stage.round_trips(reach, max(count - 2 * GROUP, GROUP), partner)
        last = stage.round_trips(reach, GROUP, partner)
        client.destroy()
        node.destroy_node()
        rclpy.shutdown()
        return middle | {'growth': last['p50'] / first['p50']}


if __name__ == '__main__':
    stage.run(ask, answer)
