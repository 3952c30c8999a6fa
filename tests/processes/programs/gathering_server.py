"""An action server whose goals all wait for each other. Argument: how many have to come together."""

import sys

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future


class GatheringServer(Node):
    def __init__(self, number: int) -> None:
        super().__init__('gathering_server')
        self._missing = number
        self._all_here: Future[None] = Future()
        self._server = ActionServer(self, Fibonacci, 'gather', self.execute)
        print('ready')

    async def execute(self, goal: ServerGoalHandle) -> Fibonacci.Result:
        self._missing -= 1
        goal.publish_feedback(Fibonacci.Feedback(sequence=[goal.request.order]))
        if self._missing == 0:
            self._all_here.set_result(None)
        await self._all_here
        goal.succeed()
        return Fibonacci.Result(sequence=[goal.request.order, self._missing])


def main(number: int) -> None:
    try:
        with rclpy.init():
            rclpy.spin(GatheringServer(number))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    print('stopped')


if __name__ == '__main__':
    main(int(sys.argv[1]))
