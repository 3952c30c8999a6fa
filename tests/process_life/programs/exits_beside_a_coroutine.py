"""A forked child ends by sys.exit(); the parent's coroutine callback goes on waiting for its socket."""

from __future__ import annotations

import asyncio
import os
import socket
import sys

import rclpy
from forked import LIMIT_S, end_of, expect
from rclpy.task import Future

rclpy.init()
node = rclpy.create_node('exits_beside_a_coroutine')
near, far = socket.socketpair()
near.setblocking(False)
received: Future[bytes] = Future()
waits: Future[None] = Future()


async def receive() -> None:
    waits.set_result(None)
    try:
        received.set_result(await asyncio.get_running_loop().sock_recv(near, 16))
    except asyncio.CancelledError:
        received.set_result(b'was cancelled')
        raise


executor = rclpy.get_global_executor()
executor.add_node(node)
receiving = executor.create_task(receive)
executor.spin_until_future_complete(waits, timeout_sec=LIMIT_S)
executor.spin_once(timeout_sec=0.05)
child = os.fork()
if child == 0:
    sys.exit()
expect('child', end_of(child), 0)
far.send(b'hello')
executor.spin_until_future_complete(received, timeout_sec=5)
expect('received', received.result() if received.done() else None, b'hello')
node.destroy_node()
rclpy.shutdown()
print('good')
