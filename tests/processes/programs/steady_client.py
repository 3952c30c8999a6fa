"""Calls a service again and again, the next call after each answer. Argument: the service's name."""

import sys
from itertools import count

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.node import Node
from rclpy.task import Future


class SteadyClient(Node):
    """Ten calls a second; one that is not answered is let be."""

    def __init__(self, service: str) -> None:
        super().__init__(f'{service}_client')
        self._client = self.create_client(AddTwoInts, service)
        assert self._client.wait_for_service(timeout_sec=20.0)
        self._next = count().__next__
        self.create_timer(0.1, self.call)

    def call(self) -> None:
        number = self._next()
        request = AddTwoInts.Request(a=number, b=1000)
        self._client.call_async(request).add_done_callback(lambda future: self.on_answer(number, future))

    def on_answer(self, number: int, future: 'Future[AddTwoInts.Response]') -> None:
        answer = future.result()
        assert answer is not None
        assert answer.sum == number + 1000
        print(f'answer {number}')


def main(service: str) -> None:
    with rclpy.init():
        rclpy.spin(SteadyClient(service))


if __name__ == '__main__':
    main(*sys.argv[1:])
