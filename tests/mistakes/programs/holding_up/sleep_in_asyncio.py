# time.sleep() stands in a program of the asyncio API.
# says: and other callbacks wait for it: write 'await asyncio.sleep(…)' and not time.sleep(), and 'await asyncio.to_thread(function)' for what takes long
# within: 5 s
# ctrl-c: yes
import asyncio
import time

import goalwire


async def work(node):
    async for _ in node.timer(0.2):
        time.sleep(8)  # <-- here


async def main():
    async with goalwire.Node('robot') as node:
        await work(node)


asyncio.run(main())
