"""Loggers: levels, filters, refusals; /rosout; the services that read and set levels."""

import os
import time

import rclpy
import rclpy.logging
from rcl_interfaces.msg import Log, LoggerLevel
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy.clock import Clock, ClockType
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.impl.rcutils_logger import get_filters_from_kwargs
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

# -- before init

get_logger('early').info('x')
get_logger('early').debug('x')
rclpy.logging.get_logging_directory().name == os.environ.get('ROS_LOG_DIR', '').rpartition('/')[2]

# -- loggers and levels

get_logger('')
get_logger(None)
p = get_logger('p')
c = p.get_child('c')
(p.name, c.name)
p.get_child('')
p.get_child(None)
p.get_effective_level()
p.set_level(LoggingSeverity.ERROR)
(p.get_effective_level(), c.get_effective_level())
c.set_level(10)
(p.get_effective_level(), c.get_effective_level())
c.set_level(LoggingSeverity.UNSET)
c.get_effective_level()
p.set_level('DEBUG')
p.set_level(5)
p.set_level(99)
(p.is_enabled_for(LoggingSeverity.ERROR), p.is_enabled_for(30), p.is_enabled_for(40))
p.is_enabled_for(25)
rclpy.logging.get_logger_level('nope')
rclpy.logging.get_logger_level('')
rclpy.logging.get_logger_effective_level('nope')
rclpy.logging.set_logger_level('q', LoggingSeverity.FATAL)
(rclpy.logging.get_logger_level('q'), rclpy.logging.get_logger_effective_level('q.x.y'))
rclpy.logging.set_logger_level('q', 0)
rclpy.logging.get_logger_effective_level('q')
rclpy.logging.get_logging_severity_from_string('info')
rclpy.logging.get_logging_severity_from_string('WaRn')
rclpy.logging.get_logging_severity_from_string('loud')
list(LoggingSeverity)

# -- calls

a = get_logger('a')
a.info('x')
a.debug('x')
a.log('x', 20)
a.log('x', LoggingSeverity.DEBUG)
a.log('x', 'INFO')
a.log('x', 25)
a.info(None)
a.info(b'x')
a.info('')
a.info('%s {}')
a.info(5)
a.info('a %s', 'b')
a.info('a', foo=1)
a.warn('x')
a.info('m', name='other')
[getattr(a, kind)('m') for kind in ('info', 'warn')]
[a.info('m', **options) for options in ({}, {'once': True})]
[a.info('m', name=name) for name in ('one', 'two')]

# -- filters

[a.info('m', once=True) for _ in range(3)]
[a.info('m', skip_first=True) for _ in range(3)]
[a.info('m', once=True, skip_first=True) for _ in range(3)]
[a.info('m', throttle_duration_sec=1000) for _ in range(3)]
[a.info('m', throttle_duration_sec=-1) for _ in range(3)]
[a.info('m', throttle_duration_sec=1000, throttle_time_source_type=Clock()) for _ in range(1)]
steady = Clock(clock_type=ClockType.STEADY_TIME)
a.info('m', throttle_duration_sec=1, throttle_time_source_type='STEADY_TIME')
a.info('m', throttle_time_source_type=steady)
get_filters_from_kwargs(once=True)
get_filters_from_kwargs(skip_first=True, once=True, throttle_duration_sec=1.0)
get_filters_from_kwargs()
get_filters_from_kwargs(foo=1)

# -- /rosout

initialized = rclpy.init(args=['--ros-args', '--log-level', 'quiet:=fatal'])
n = Node('talker', namespace='ns', enable_logger_service=True)
silent = Node('silent', enable_rosout=False)
listener = Node('listener', enable_rosout=False)
heard = []
history = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
subscription = listener.create_subscription(Log, '/rosout', heard.append, history)


def hear(count):
    """Spin until so many lines have come; tell of them."""
    end = time.monotonic() + 10
    while len(heard) < count and time.monotonic() < end:
        rclpy.spin_once(listener, timeout_sec=0.05)
    lines = [(log.level, log.name, log.msg, log.function, log.file == __file__) for log in heard]
    heard.clear()
    return lines


def speak():
    n.get_logger().warning('in a function')


n.get_logger().name
n.get_logger().info('plain')
hear(1)
speak()
n.get_logger().get_child('kid').error('of a child')
get_logger('ns.talker').info('of a namesake')
hear(3)
n.get_logger().debug('below the level')
silent.get_logger().info('of a node without rosout')
get_logger('nobody').info('of no node')
get_logger('ns.talker.stranger').info('of no child')
n.get_logger().info('two\nlines')
n.get_logger().fatal('last')
hear(2)
rclpy.logging.get_logger_effective_level('quiet.child')
sorted(publisher.topic_name for publisher in n.publishers)
sorted(n.get_publisher_names_and_types_by_node('talker', '/ns'))
n.count_publishers('/rosout')
[(info.node_name, info.topic_type) for info in n.get_publishers_info_by_topic('/rosout')]
[str(info.qos_profile.durability) for info in n.get_publishers_info_by_topic('/rosout')]

# -- the services

[service.service_name for service in n.services if 'logger' in service.service_name]
get_levels = listener.create_client(GetLoggerLevels, '/ns/talker/get_logger_levels')
set_levels = listener.create_client(SetLoggerLevels, '/ns/talker/set_logger_levels')


def call(client, request):
    client.wait_for_service(10)
    future = client.call_async(request)
    rclpy.get_global_executor().add_node(listener)
    rclpy.spin_until_future_complete(n, future, timeout_sec=10)
    rclpy.get_global_executor().remove_node(listener)
    return future.result()


call(get_levels, GetLoggerLevels.Request(names=['', 'p', 'p.c', 'nope']))
wanted = [LoggerLevel(name='s', level=10), LoggerLevel(name='t', level=77)]
call(set_levels, SetLoggerLevels.Request(levels=wanted))
call(get_levels, GetLoggerLevels.Request(names=['s', 't']))
call(set_levels, SetLoggerLevels.Request(levels=[LoggerLevel(name='s', level=0)]))
get_logger('s').get_effective_level()
n.destroy_node()
n.get_logger().info('after the node')
rclpy.shutdown()
n.get_logger().info('after the context')
