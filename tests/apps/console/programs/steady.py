"""Publishes at a steady pace: /steady ten times a second, /slow each second, and /latched once."""

import asyncio

from std_msgs.msg import Float64, String

import goalwire


async def main():
    async with goalwire.Node('steady') as node:
        steady, slow = node.publisher(Float64, 'steady'), node.publisher(Float64, 'slow')
        history = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        node.publisher(String, 'latched', qos=history).publish(data='once')
        print('ready', flush=True)
        count = 0
        async for _ in node.timer(0.1):
            steady.publish(data=float(count))
            if count % 10 == 0:
                slow.publish(data=float(count))
            count += 1


asyncio.run(main())
