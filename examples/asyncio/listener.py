"""Hears what is said on the topic `chatter`. Its other half is talker.py, or any of ROS 2.

python examples/asyncio/listener.py
"""

import asyncio

from std_msgs.msg import String

import goalwire


async def main():
    async with goalwire.Node('listener') as node:
        async for message in node.subscription(String, 'chatter'):
            node.logger.info(f'Heard: {message.data}')


try:
    asyncio.run(main())
except KeyboardInterrupt:
    pass
