"""A simulation: its time is published again and again, and goes on by a second each time."""

import asyncio
import itertools

from rosgraph_msgs.msg import Clock

import goalwire


async def main():
    async with goalwire.Node('simulation') as node:
        clock = node.publisher(Clock, '/clock')
        for second in itertools.count(1000):
            message = Clock()
            message.clock.sec = second
            clock.publish(message)
            await asyncio.sleep(0.02)
            if second == 1000:
                print('ready', flush=True)


asyncio.run(main())
