"""Goals of one client, many at a time: for the curves."""

from __future__ import annotations

from time import perf_counter
from typing import Any

from benchmarks import spinning, stage
from benchmarks.line import Figures
from benchmarks.lines.action_goals import ACTION


def ask(count: int, window: int) -> Figures:
    import rclpy
    from rclpy.action import ActionClient

    from benchmarks.lines.fibonacci import Fibonacci

    with stage.Partner('benchmarks.lines.action_goals') as partner:
        rclpy.init()
        node = rclpy.create_node('bench_client')
        client = ActionClient(node, Fibonacci, ACTION)
        assert client.wait_for_server(spinning.PATIENCE_S)
        all_done: rclpy.Future[None] = rclpy.Future()
        left, reached = count, 0

        def send() -> None:
            nonlocal left
            if left:
                left -= 1
                client.send_goal_async(Fibonacci.Goal(order=1)).add_done_callback(accepted)

        def accepted(future: rclpy.Future[Any]) -> None:
            goal = future.result()
            assert goal is not None
            goal.get_result_async().add_done_callback(ended)

        def ended(_future: rclpy.Future[Any]) -> None:
            nonlocal reached
            reached += 1
            if reached == count:
                all_done.set_result(None)
            send()

        meter, begun = stage.Meter(partner), perf_counter()
        for _ in range(window):
            send()
        spinning.spin_until_done(node, all_done, 3 * spinning.PATIENCE_S)
        taken = perf_counter() - begun
        figures = meter.read(reached) | {'rate': reached / taken, 'lost': count - reached}
        client.destroy()
        node.destroy_node()
        rclpy.shutdown()
        return figures


if __name__ == '__main__':
    stage.run(ask, lambda: None)
