"""`Process.start(); p.terminate()` ends the child, and neither the parent's context nor its node."""

from __future__ import annotations

import multiprocessing
import sys
import time

import rclpy
from forked import expect
from rclpy.executors import ExternalShutdownException

rclpy.init()
node = rclpy.create_node('terminate_at_once')
fork = multiprocessing.get_context('fork')
ended_at = None
for number in range(int(sys.argv[1]) if sys.argv[1:] else 20):
    process = fork.Process(target=time.sleep, args=(0,))
    process.start()
    process.terminate()
    process.join(20)
    try:
        rclpy.spin_once(node, timeout_sec=0.02)  # whoever hears signals hears them now
    except ExternalShutdownException:
        ended_at = number
        break
expect('the context has ended after process', ended_at, None)
expect('ok', rclpy.ok(), True)
node.destroy_node()
rclpy.shutdown()
print('good')
