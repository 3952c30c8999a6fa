"""Nodes to look at: services, an action, topics, parameters."""

import sys
from contextlib import suppress
from threading import Event
from time import sleep

import rclpy
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.service_introspection import ServiceIntrospectionState
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger


def add(request, response):
    response.sum = request.a + request.b
    return response


def slow(request, response):
    sleep(30)
    return response


def execute(goal_handle):
    order = goal_handle.request.order
    feedback = Fibonacci.Feedback(sequence=[0, 1])
    while len(feedback.sequence) <= order % 1000:
        if goal_handle.is_cancel_requested:
            sleep({3005: 20, 5005: 0.3}.get(order, 0))
            goal_handle.canceled()
            return Fibonacci.Result(sequence=feedback.sequence)
        feedback.sequence.append(feedback.sequence[-1] + feedback.sequence[-2])
        goal_handle.publish_feedback(feedback)
        waited = 0
        while (
            order >= 1000
            and not goal_handle.is_cancel_requested
            and waited < (200 if order == 2005 else 2000)
        ):
            sleep(0.01)
            waited += 1
    if order == 13:
        goal_handle.abort()
    else:
        goal_handle.succeed()
    return Fibonacci.Result(sequence=feedback.sequence)


speaks = Event()
"""Set once a message 'speak' has come: until then it does not answer who cancels a goal of order 4005."""


def hear(message):
    print('heard', message.data, flush=True)
    if message.data == 'speak':
        speaks.set()


def answer_cancel(goal):
    if goal.request.order == 4005:
        speaks.wait(60)
    return CancelResponse.REJECT if goal.request.order == 2005 else CancelResponse.ACCEPT


def main():
    rclpy.init()
    node = rclpy.create_node('workshop', namespace='/lab')
    hidden = rclpy.create_node('_hidden')
    group = ReentrantCallbackGroup()
    service = node.create_service(AddTwoInts, 'add', add, callback_group=group)
    service.configure_introspection(
        node.get_clock(), QoSProfile(depth=10), ServiceIntrospectionState.CONTENTS
    )
    node.create_service(Trigger, 'slow', slow, callback_group=group)
    node.create_service(Trigger, '_secret', slow, callback_group=group)
    ActionServer(
        node,
        Fibonacci,
        'fibonacci',
        execute,
        callback_group=group,
        goal_callback=lambda goal: GoalResponse.REJECT if goal.order < 0 else GoalResponse.ACCEPT,
        cancel_callback=answer_cancel,
    )
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_publisher(String, 'state', latched).publish(String(data='ready \x1b[31m'))
    node.create_subscription(String, 'orders', hear, 10)
    client = hidden.create_client(SetBool, '/lab/switch')
    node.declare_parameter('speed', 1.5)
    node.declare_parameter(
        'gears', 3, ParameterDescriptor(integer_range=[IntegerRange(from_value=1, to_value=5, step=1)])
    )
    node.declare_parameter('arm.names', ['left', 'right'])
    node.declare_parameter('fixed', 'yes', ParameterDescriptor(read_only=True, description='stays'))
    node.add_on_set_parameters_callback(
        lambda given: SetParametersResult(
            successful=all(each.name != 'speed' or each.value < 10 for each in given), reason='too fast'
        )
    )
    executor = MultiThreadedExecutor(12)
    executor.add_node(node)
    executor.add_node(hidden)
    print('ready', flush=True)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()
    del client


sys.exit(main())
