"""Forks while other threads open contexts and close them: no child has a socket of the parent.

Arguments: how many children.
"""

from __future__ import annotations

import sys
import threading

import rclpy
from child import network_sockets
from forked import expect, in_child
from rclpy.context import Context

CHILDREN = int(sys.argv[1])
over = threading.Event()


def open_and_close() -> None:
    while not over.is_set():
        context = Context()
        rclpy.init(context=context)
        node = rclpy.create_node(f'brief_{threading.get_ident()}', context=context)
        node.destroy_node()
        context.try_shutdown()


def look() -> None:
    expect('sockets of the parent in a child', network_sockets(), [])


rclpy.init()
stays = rclpy.create_node('stays')
threads = [threading.Thread(target=open_and_close) for _ in range(2)]
for each in threads:
    each.start()
codes = [in_child(look) for _ in range(CHILDREN)]
over.set()
for each in threads:
    each.join()
stays.destroy_node()
rclpy.shutdown()
expect('children', codes, [0] * CHILDREN)
print('good')
