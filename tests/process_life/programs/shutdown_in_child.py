"""rclpy.shutdown() in a forked child returns, while a thread of the parent spins and watches a socket."""

from __future__ import annotations

import asyncio
import socket
import threading

import rclpy
from forked import expect, in_child
from std_srvs.srv import Empty

rclpy.init()
node = rclpy.create_node('shutdown_in_child')
client = node.create_client(Empty, 'serve')
node.create_service(Empty, 'serve', lambda request, response: response)
executor = rclpy.get_global_executor()
spinning = threading.Thread(target=rclpy.spin, args=(node,))
spinning.start()
client.wait_for_service()
near, far = socket.socketpair()
near.setblocking(False)


async def receive() -> bytes:
    return await asyncio.get_running_loop().sock_recv(near, 16)


received = executor.create_task(receive)
for _ in range(3):
    client.call(Empty.Request())  # it spins, and has begun with the coroutine
for _ in range(4):
    expect('child', in_child(rclpy.shutdown, 6), 0)
far.send(b'hello')
while not received.done():
    client.call(Empty.Request())
expect('received', received.result(), b'hello')
rclpy.shutdown()
spinning.join()
print('good')
