"""Knows of no deadline: calls, and waits for a goal, in every way, and tells how each ends."""

import sys
import threading

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

told: list[str] = []
over: Future[bool] = Future()


def tell(way: str, error: object) -> None:
    who = 'node' if "'/holder'" in str(error) else error
    sys.stdout.write(f'{way} {type(error).__name__} {who}\n')
    sys.stdout.flush()
    told.append(way)
    if len(told) == 5:
        over.set_result(True)


def call() -> None:
    try:
        tell('call', client.call(Trigger.Request()))
    except Exception as error:
        tell('call', error)


def get_result() -> None:
    assert handle is not None
    try:
        tell('get_result', handle.get_result())
    except Exception as error:
        tell('get_result', error)


async def awaited() -> None:
    timer.cancel()
    try:
        tell('await', await client.call_async(Trigger.Request()))
    except Exception as error:
        tell('await', error)


with rclpy.init():
    node = Node('waiter')
    client = node.create_client(Trigger, 'hold')
    moving = ActionClient(node, Fibonacci, 'hold_on')
    assert client.wait_for_service(30.0)
    assert moving.wait_for_server(30.0)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    accepted = moving.send_goal_async(Fibonacci.Goal())
    executor.spin_until_future_complete(accepted)
    handle = accepted.result()
    assert handle is not None
    threads = [threading.Thread(target=each) for each in (call, get_result)]
    for thread in threads:
        thread.start()
    timer = node.create_timer(0.01, awaited)
    client.call_async(Trigger.Request()).add_done_callback(lambda done: tell('call_async', done.exception()))
    handle.get_result_async().add_done_callback(lambda done: tell('get_result_async', done.exception()))
    print('waiting', flush=True)
    executor.spin_until_future_complete(over, timeout_sec=60.0)
    for thread in threads:
        thread.join()
