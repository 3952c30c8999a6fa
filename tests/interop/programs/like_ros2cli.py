"""As ros2cli: a node without a daemon; service call and echo, param, action, interface show, pkg and run."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import rclpy
from ament_index_python import get_packages_with_prefixes
from example_interfaces.action import Fibonacci
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import qos_profile_services_default
from rclpy.service_introspection import ServiceIntrospectionState
from rosidl_adapter.parser import parse_message_string
from rosidl_runtime_py import get_interface_path, message_to_yaml, set_message_fields
from rosidl_runtime_py.utilities import get_action, get_service
from service_msgs.msg import ServiceEventInfo


class DirectNode:
    """The node that every verb works with."""

    def __enter__(self):
        rclpy.init(args=[])
        self.node = rclpy.create_node(
            f'_ros2cli_{os.getpid()}', start_parameter_services=False, enable_rosout=False
        )
        timer = self.node.create_timer(0.01, lambda: setattr(self, 'ready', True))
        self.ready = False
        with timer:
            while not self.ready:
                rclpy.spin_once(self.node)
        self.node.destroy_timer(timer)
        return self.node

    def __exit__(self, *_):
        self.node.destroy_node()
        rclpy.shutdown()


def serve():
    """The robot that is looked at, until its standard input ends."""
    rclpy.init(args=[])
    node = rclpy.create_node('robot', allow_undeclared_parameters=True)
    service = node.create_service(get_service('std_srvs/srv/SetBool'), 'light', answer)
    clock = node.get_clock()
    service.configure_introspection(clock, qos_profile_services_default, ServiceIntrospectionState.CONTENTS)
    node.set_parameters([rclpy.Parameter('speed', value=3)])
    ActionServer(node, Fibonacci, 'fib', execute)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    sys.stdin.read()
    print('speed is there', node.has_parameter('speed'))
    executor.shutdown()
    spinning.join()
    rclpy.shutdown()


def answer(request, response):
    response.message = f'light {request.data}'
    return response


def execute(handle):
    handle.succeed()
    return Fibonacci.Result(sequence=[handle.request.order])


def call(node, service, name, request):
    client = node.create_client(service, name)
    assert client.wait_for_service(timeout_sec=10.0)
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future)
    return future.result()


def verbs(node):
    names = {value: key for key, value in ServiceEventInfo._Metaclass_ServiceEventInfo__constants.items()}
    heard = []
    light = get_service('std_srvs/srv/SetBool')
    node.create_subscription(light.Event, '/light/_service_event', heard.append, qos_profile_services_default)
    while node.count_publishers('/light/_service_event') == 0:
        rclpy.spin_once(node, timeout_sec=0.1)
    request = light.Request()
    set_message_fields(request, {'data': True})
    print(message_to_yaml(call(node, light, '/light', request)).splitlines())
    while len(heard) < 2:
        rclpy.spin_once(node, timeout_sec=1.0)
    print([names[event.info.event_type] for event in heard])

    fib = ActionClient(node, get_action('example_interfaces/action/Fibonacci'), '/fib')
    fib.wait_for_server()
    sent = fib.send_goal_async(Fibonacci.Goal(order=4))
    rclpy.spin_until_future_complete(node, sent)
    result = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, result)
    print('goal', result.result().status, list(result.result().result.sequence))

    with Path(get_interface_path('std_msgs/msg/Header')).open(encoding='utf-8') as lines:
        specs = [parse_message_string('std_msgs', 'Header', line.rstrip()) for line in lines]
    print([str(spec.fields[0].type) for spec in specs if spec.fields])

    parameter = Parameter()
    Parameter.name = 'speed'  # of the class, as `ros2 param delete` has it
    parameter.value = ParameterValue(type=ParameterType.PARAMETER_NOT_SET)
    request = SetParameters.Request(parameters=[parameter])
    print('deleted', call(node, SetParameters, '/robot/set_parameters', request).results[0].successful)

    prefixes = get_packages_with_prefixes()
    shares = [name for name in prefixes if not Path(prefixes[name], 'share', name).is_dir()]
    print('without a share folder', shares)


def main():
    with subprocess.Popen([sys.executable, __file__, 'robot'], stdin=subprocess.PIPE) as robot:
        with DirectNode() as node:
            verbs(node)
        sys.stdout.flush()
        robot.stdin.close()


serve() if sys.argv[1:] == ['robot'] else main()
