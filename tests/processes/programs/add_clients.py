"""Many clients of one service. Arguments: which process this is, how many clients, calls of each, at once."""

import sys
from itertools import count

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.node import Node
from rclpy.task import Future


class Caller:
    """One client with a number of calls in flight until all are made."""

    def __init__(self, node: Node, first: int, calls: int) -> None:
        self._client = node.create_client(AddTwoInts, 'add')
        self._first = first
        self._calls = calls
        self._next = count().__next__
        self.answers: set[int] = set()
        self.finished: Future[None] = Future()

    def wait_for_service(self) -> None:
        assert self._client.wait_for_service(timeout_sec=20.0)

    def start(self, at_once: int) -> None:
        for _ in range(at_once):
            self._call()

    def _call(self) -> None:
        call = self._next()
        if call < self._calls:
            request = AddTwoInts.Request(a=self._first, b=call)
            self._client.call_async(request).add_done_callback(self._on_answer)

    def _on_answer(self, future: 'Future[AddTwoInts.Response]') -> None:
        answer = future.result()
        assert answer is not None
        assert answer.sum not in self.answers
        self.answers.add(answer.sum)
        if len(self.answers) == self._calls:
            self.finished.set_result(None)
        self._call()


def main(number: int, clients: int, calls: int, at_once: int) -> None:
    with rclpy.init():
        node = rclpy.create_node(f'clients_{number}')
        mine = range(number * clients * calls, (number + 1) * clients * calls)
        callers = [Caller(node, first, calls) for first in mine[::calls]]
        for caller in callers:
            caller.wait_for_service()
        print('ready')
        input()
        for caller in callers:
            caller.start(at_once)
        for caller in callers:
            rclpy.spin_until_future_complete(node, caller.finished)
        answers = sorted(answer for caller in callers for answer in caller.answers)
        assert answers == list(mine)
        print(f'{len(answers)} right answers')


if __name__ == '__main__':
    main(*map(int, sys.argv[1:]))
