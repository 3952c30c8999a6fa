"""A server whose callback takes a minute, and that Ctrl-C ends. Arguments: its service, and how it works.

`blocks` sleeps in the callback, on the main thread; `threads` on another one; `awaits` sleeps in a coroutine.
`bare` in place of `blocks` catches no KeyboardInterrupt.
"""

from __future__ import annotations

import asyncio
import sys
import time

import rclpy
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from std_srvs.srv import Trigger

MINUTE_S = 60.0


def sleep(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
    print('asked')
    time.sleep(MINUTE_S)
    return response


async def wait(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
    print('asked')
    await asyncio.sleep(MINUTE_S)
    return response


def main(service: str, how: str) -> None:
    rclpy.init(args=[])
    node = rclpy.create_node('sleeper')
    node.create_service(Trigger, service, wait if how == 'awaits' else sleep)
    executor: Executor = MultiThreadedExecutor(4) if how == 'threads' else SingleThreadedExecutor()
    executor.add_node(node)
    try:
        print('ready')
        executor.spin()
    except KeyboardInterrupt:
        if how == 'bare':
            raise
    finally:
        rclpy.try_shutdown()
        print('gone')


if __name__ == '__main__':
    main(*sys.argv[1:])
