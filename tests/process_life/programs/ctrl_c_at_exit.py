"""Ctrl-C comes while the interpreter's exit closes things.

Usage: ctrl_c_at_exit.py STAGE|SECONDS: at that stage of the exit, or so long after its beginning.
"""

from __future__ import annotations

import os
import signal
import sys
import threading

import rclpy
from rclpy.utilities import get_default_context
from std_msgs.msg import String

from goalwire.concurrency.exits import Stage, at_exit
from goalwire.transport.endpoint import OpenSession

rclpy.init()
node = rclpy.create_node('ctrl_c_at_exit')
publisher = node.create_publisher(String, 'last_words', 10)
session = get_default_context().session
assert isinstance(session, OpenSession)
state = session.state
publisher.publish(String(data='bye'))
if sys.argv[1].isupper():
    at_exit(Stage[sys.argv[1]], lambda: os.kill(os.getpid(), signal.SIGINT))
else:
    timer = threading.Timer(float(sys.argv[1]), os.kill, (os.getpid(), signal.SIGINT))
    timer.daemon = True
    timer.start()
at_exit(Stage.SIGNALS, lambda: print('the session is closed:', state.closed))
