"""A server whose handler fails."""

import asyncio

from std_srvs.srv import Trigger

import goalwire


async def fail(request):
    raise RuntimeError('out of order')


async def main():
    async with goalwire.Node('broken') as node:
        node.service(Trigger, 'broken', fail)
        print('ready', flush=True)
        await asyncio.Event().wait()


asyncio.run(main())
