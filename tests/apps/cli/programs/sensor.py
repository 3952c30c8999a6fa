"""Publishes stamped points and a text, fifty times a second."""

import asyncio
from contextlib import suppress

from geometry_msgs.msg import PointStamped
from std_msgs.msg import String

import goalwire


async def main():
    async with goalwire.Node('sensor') as node:
        points, texts = node.publisher(PointStamped, 'point'), node.publisher(String, 'text')
        message = PointStamped()
        message.header.frame_id = 'lab'
        print('ready', flush=True)
        async for time in node.timer(0.02):
            message.header.stamp = time.to_msg()
            message.point.x += 1.0
            points.publish(message)
            texts.publish(data='evil \x1b[31m\nred')


with suppress(KeyboardInterrupt):
    asyncio.run(main())
