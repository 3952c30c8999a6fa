"""Sets the parameter of limits.py, badly and well; tells what came back and what was published."""

import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.parameter_event_handler import ParameterEventHandler
from rclpy.task import Future

with rclpy.init():
    node = Node('asker')
    heard: Future[int] = Future()
    handler = ParameterEventHandler(node)
    handler.add_parameter_callback(
        'speed', '/lab/limits', lambda found: heard.set_result(found.value.integer_value)
    )
    client = AsyncParameterClient(node, '/lab/limits')
    assert client.wait_for_services(20.0)
    for value in (500, 95):
        future = client.set_parameters([Parameter('speed', value=value)])
        rclpy.spin_until_future_complete(node, future, timeout_sec=20.0)
        answer = future.result()
        assert answer is not None
        print(answer.results[0].successful, answer.results[0].reason, flush=True)
    rclpy.spin_until_future_complete(node, heard, timeout_sec=20.0)
    print('heard', heard.result())
