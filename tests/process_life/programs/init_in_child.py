"""rclpy.init() in a forked child of an initialised parent opens a context of its own, or says why not."""

from __future__ import annotations

import sys

import rclpy
from forked import expect, in_child
from rclpy.task import Future
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('parent')


def work() -> None:
    """Open a context, hear oneself, and end."""
    rclpy.init()
    mine = rclpy.create_node('child')
    heard: Future[String] = Future()
    mine.create_subscription(String, 'words', heard.set_result, 1)
    publisher = mine.create_publisher(String, 'words', 1)
    mine.create_timer(0.05, lambda: publisher.publish(String(data='hello')))
    rclpy.spin_until_future_complete(mine, heard, timeout_sec=10)
    message = heard.result()
    expect('heard', message and message.data, 'hello')
    rclpy.shutdown()
    expect('ok in the child', rclpy.ok(), False)


def be_refused() -> None:
    """The library below cannot be started again in a child: the error says so."""
    rclpy.init()
    try:
        rclpy.create_node('child')
    except Exception as error:
        expect('the error', type(error).__name__, 'ForkedError')
    else:
        expect('an error', None, 'one')
    rclpy.try_shutdown()


expect('child', in_child(be_refused if 'refused' in sys.argv else work), 0)
expect('ok', rclpy.ok(), True)
node.destroy_node()
rclpy.shutdown()
print('good')
