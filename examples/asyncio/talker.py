"""Says hello twice a second on the topic `chatter`. Its other half is listener.py.

python examples/asyncio/talker.py
"""

import asyncio
from itertools import count

from std_msgs.msg import String

import goalwire


async def main():
    async with goalwire.Node('talker') as node:
        chatter = node.publisher(String, 'chatter')
        numbers = count(1)
        async for _ in node.timer(0.5):
            text = f'Hello number {next(numbers)}'
            chatter.publish(data=text)
            node.logger.info(f'Said: {text}')


try:
    asyncio.run(main())
except KeyboardInterrupt:
    pass
