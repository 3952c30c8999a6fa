"""Logging: what is printed and what is returned, levels, filters, children, log files, rosout."""

import os
import re
import tempfile

import rclpy
import rclpy.logging
from rcl_interfaces.msg import Log
from rclpy.clock import Clock
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import LoggingSeverity, get_logger
from rclpy.node import Node


def printed(call):
    """Return what a call gives, and what it writes to standard error, without times."""
    with tempfile.TemporaryFile() as file:
        before = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            gives = call()
        finally:
            os.dup2(before, 2)
            os.close(before)
        file.seek(0)
        text = file.read().decode()
    return gives, re.sub(r'\[\d+\.\d{9}\]', '[T]', text)


log = get_logger('ln')
printed(lambda: log.debug('d'))
printed(lambda: log.info('i'))
printed(lambda: log.warning('w'))
printed(lambda: log.warning('w'))
printed(lambda: log.error('e'))
printed(lambda: log.fatal('f'))
printed(lambda: log.log('x', 20))
printed(lambda: log.log('x', LoggingSeverity.ERROR))
log.log('x', 'INFO')
log.log('x', 25)
printed(lambda: log.info('two\nlines'))
printed(lambda: log.info(''))
printed(lambda: log.info('%s {}'))
printed(lambda: log.info('é'))
log.info('a %s', 'b')
log.info('a', foo=1)
printed(lambda: log.info('m', name='other'))
log.name
get_logger('p').get_child('c').name
get_logger('')
get_logger(None)
get_logger('p').get_child('')
get_logger('p').get_child('c').get_child('d').name

# -- levels

parent, child = get_logger('p'), get_logger('p').get_child('c')
parent.get_effective_level()
parent.set_level(LoggingSeverity.ERROR)
(parent.get_effective_level(), child.get_effective_level())
child.set_level(LoggingSeverity.DEBUG)
child.get_effective_level()
child.is_enabled_for(LoggingSeverity.DEBUG)
parent.is_enabled_for(LoggingSeverity.WARN)
child.set_level(LoggingSeverity.UNSET)
child.get_effective_level()
parent.set_level('DEBUG')
parent.set_level(5)
parent.set_level(10)
parent.get_effective_level()
printed(lambda: parent.debug('seen'))
rclpy.logging.get_logger_level('nope')
rclpy.logging.get_logger_effective_level('nope')
rclpy.logging.set_logger_level('', 40)
printed(lambda: log.info('hidden'))
printed(lambda: log.error('shown'))
rclpy.logging.set_logger_level('', 20)
rclpy.logging.get_logging_severity_from_string('info')
rclpy.logging.get_logging_severity_from_string('WARN')
rclpy.logging.get_logging_severity_from_string('x')
[(severity.name, int(severity)) for severity in LoggingSeverity]

# -- filters

printed(lambda: [log.info('once', once=True) for _ in range(3)])
printed(lambda: [log.info('skip', skip_first=True) for _ in range(3)])
printed(lambda: [log.info('both', once=True, skip_first=True) for _ in range(3)])
printed(lambda: [log.info('throttled', throttle_duration_sec=60) for _ in range(3)])
printed(
    lambda: [log.info('clock', throttle_duration_sec=60, throttle_time_source_type=Clock()) for _ in range(2)]
)
log.info('m', throttle_duration_sec=1, throttle_time_source_type='STEADY_TIME')
log.info('m', throttle_time_source_type=Clock())
printed(lambda: [getattr(log, level)('any') for level in ('info', 'info')])
[getattr(log, level)('any') for level in ('info', 'error')]

# -- nodes

initialized = rclpy.init(
    args=['program', '--ros-args', '--log-level', 'q:=error', '--log-level', 'n.deep:=debug']
)
get_logger('q').get_effective_level()
get_logger('q.child').get_effective_level()
get_logger('n.deep').get_effective_level()
n = Node('n', namespace='/a')
n.get_logger().name
printed(lambda: n.get_logger().info('from a node'))
printed(lambda: n.get_logger().get_child('deep').warn('from a child'))

# -- rosout

listener = Node('listener', enable_rosout=False)
heard = []
s = listener.create_subscription(Log, '/rosout', heard.append, 100)
executor = SingleThreadedExecutor()
executor.add_node(listener)
for _ in range(200):
    if s.get_publisher_count():
        break
    executor.spin_once(timeout_sec=0.05)


def func():
    return n.get_logger().warn('to rosout')


printed(func)
printed(lambda: n.get_logger().get_child('ch').error('a child'))
printed(lambda: get_logger('nobody').error('no node'))
printed(lambda: listener.get_logger().error('no rosout'))
printed(lambda: n.get_logger().debug('too low'))
printed(lambda: n.get_logger().fatal('last'))
for _ in range(200):
    if any(message.msg == 'last' for message in heard):
        break
    executor.spin_once(timeout_sec=0.05)
mine = [message for message in heard if message.name.startswith(('a.n', 'nobody', 'listener'))]
[(message.level, message.name, message.msg, message.function) for message in mine]
[message.stamp.sec > 0 for message in mine][0]
n.destroy_node()
printed(lambda: n.get_logger().info('after its end'))
rclpy.shutdown()
printed(lambda: log.info('after shutdown'))
quiet = rclpy.init(args=['program', '--ros-args', '--disable-stdout-logs'])
printed(lambda: log.error('not on the console'))
rclpy.shutdown()
