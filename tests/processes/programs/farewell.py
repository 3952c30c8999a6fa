"""A server that stops its client with a signal, answers it, has it continued a little later, and ends.

Arguments: server or client. The request's `a` is the client's process.
"""

import os
import signal
import subprocess
import sys

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.task import Future

STOPPED_S = 0.4


def serve() -> None:
    node = rclpy.create_node('server')
    answered: Future[None] = Future()

    def answer(request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        os.kill(request.a, signal.SIGSTOP)
        subprocess.Popen(['sh', '-c', f'sleep {STOPPED_S}; kill -CONT {request.a}'])
        answered.set_result(None)
        response.sum = 42
        return response

    node.create_service(AddTwoInts, 'last', answer)
    print('ready')
    rclpy.spin_until_future_complete(node, answered)
    node.destroy_node()


def ask() -> None:
    node = rclpy.create_node('client')
    client = node.create_client(AddTwoInts, 'last')
    client.wait_for_service()
    future = client.call_async(AddTwoInts.Request(a=os.getpid()))
    rclpy.spin_until_future_complete(node, future)
    answer = future.result()
    assert answer is not None
    print(f'answer {answer.sum}')


with rclpy.init():
    if sys.argv[1] == 'server':
        serve()
    else:
        ask()
