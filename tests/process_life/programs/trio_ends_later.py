"""ROS is opened before trio runs and closed while it runs: trio finds its way back, and Ctrl-C works on."""

from __future__ import annotations

import os
import signal

import rclpy
import trio

rclpy.init()
node = rclpy.create_node('trio_ends_later')


async def main() -> None:
    await trio.lowlevel.checkpoint()
    node.destroy_node()
    rclpy.shutdown()
    await trio.lowlevel.checkpoint()


trio.run(main)
trio.run(trio.lowlevel.checkpoint)
rclpy.init()
try:
    os.kill(os.getpid(), signal.SIGINT)
    trio.run(trio.sleep, 20)
except KeyboardInterrupt:
    print('interrupted, ok', rclpy.ok())
rclpy.try_shutdown()
