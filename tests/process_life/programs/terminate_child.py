"""terminate() ends a child that was forked after init, as it ends any child."""

from __future__ import annotations

import multiprocessing
import os
import signal

import rclpy
from forked import expect


def wait(ready: int) -> None:
    """Say so, and wait for a signal."""
    os.write(ready, b'x')
    while True:
        signal.pause()


rclpy.init()
node = rclpy.create_node('terminate_child')
child_is_ready, ready = os.pipe()
process = multiprocessing.get_context('fork').Process(target=wait, args=(ready,))
process.start()
os.read(child_is_ready, 1)
process.terminate()
process.join(5)
code = process.exitcode
process.kill()
expect('exit code', code, -signal.SIGTERM)
expect('ok', rclpy.ok(), True)
node.destroy_node()
rclpy.shutdown()
print('good')
