"""An action server whose goals take a step every 20 ms, as the tutorials write one."""

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node


class FibonacciServer(Node):
    def __init__(self) -> None:
        super().__init__('fibonacci_server')
        self._rate = self.create_rate(50.0)
        self._server = ActionServer(
            self,
            Fibonacci,
            'fibonacci',
            execute_callback=self.execute,
            goal_callback=lambda goal: GoalResponse.ACCEPT if goal.order > 0 else GoalResponse.REJECT,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )
        print('ready')

    def execute(self, goal: ServerGoalHandle) -> Fibonacci.Result:
        sequence = [0, 1]
        while len(sequence) <= goal.request.order:
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result(sequence=sequence)
            sequence.append(sequence[-1] + sequence[-2])
            goal.publish_feedback(Fibonacci.Feedback(sequence=sequence))
            self._rate.sleep()
        goal.succeed()
        return Fibonacci.Result(sequence=sequence)


def main() -> None:
    try:
        with rclpy.init():
            executor = MultiThreadedExecutor()
            executor.add_node(FibonacciServer())
            executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    print('stopped')


if __name__ == '__main__':
    main()
