"""A robot that is commanded by topic, service and action, and knows commands that must not come.

A negative number was sent after the sender's context had ended. Says 'moving' at the first command of each
kind, and 'LATE' for each of those.
"""

import rclpy
from example_interfaces.action import Fibonacci
from example_interfaces.msg import Int64
from example_interfaces.srv import AddTwoInts
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node


class Robot(Node):
    def __init__(self) -> None:
        super().__init__('robot')
        self._kinds: set[str] = set()
        self.create_subscription(Int64, 'move', lambda message: self.take('publish', message.data), 1000)
        self.create_service(AddTwoInts, 'step', self.step)
        self._server = ActionServer(self, Fibonacci, 'walk', self.walk)

    def take(self, kind: str, number: int) -> None:
        if number < 0:
            print(f'LATE {kind} {number}\n', end='')
        elif kind not in self._kinds:
            self._kinds.add(kind)
            print(f'moving {kind}\n', end='')  # in one piece: several threads are here at once

    def step(self, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        self.take('call', request.a)
        return response

    def walk(self, goal: ServerGoalHandle) -> Fibonacci.Result:
        self.take('goal', goal.request.order)
        goal.succeed()
        return Fibonacci.Result()


def main() -> None:
    try:
        with rclpy.init():
            executor = MultiThreadedExecutor(4)
            executor.add_node(Robot())
            print('ready')
            executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        print('stopped')


if __name__ == '__main__':
    main()
