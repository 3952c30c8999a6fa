"""A robot whose own handler, installed after init, stops it by a message: the context is still open then.

Usage: safe_stop.py SIGNAL HOW WAIT

- HOW: the handler `stays`, or `restores` the one of before as its first step, so that a second signal ends.
- WAIT: where the signal meets the main thread, in `spin` or in a `sleep`.
"""

from __future__ import annotations

import signal
import sys
import threading
import time
from types import FrameType

import rclpy
from std_msgs.msg import String

NUMBER, HOW, WAIT = signal.Signals[sys.argv[1]], sys.argv[2], sys.argv[3]

rclpy.init()
node = rclpy.create_node('safe_stop')
publisher = node.create_publisher(String, 'stop', 10)


def stop(number: int, _frame: FrameType | None) -> None:
    if HOW == 'restores':
        signal.signal(number, before)
    for _ in range(100):  # whoever would end the context has the time to do so
        publisher.publish(String(data='stop'))
        time.sleep(0.001)
    print('stopped, ok', rclpy.ok())
    node.destroy_node()
    rclpy.shutdown()
    sys.exit()


before = signal.signal(NUMBER, stop)
threading.Timer(0.05, print, ['ready']).start()
if WAIT == 'spin':
    rclpy.spin(node)
time.sleep(20)
