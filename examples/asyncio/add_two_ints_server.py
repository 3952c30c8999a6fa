"""Offers the service `add_two_ints`. Its other half is add_two_ints_client.py.

python examples/asyncio/add_two_ints_server.py
"""

import asyncio

from example_interfaces.srv import AddTwoInts

import goalwire


async def add(request):
    await asyncio.sleep(0.1)  # other requests are answered meanwhile
    return AddTwoInts.Response(sum=request.a + request.b)


async def main():
    async with goalwire.Node('add_two_ints_server') as node:
        node.service(AddTwoInts, 'add_two_ints', add)
        node.logger.info('Ready to add two ints')
        await asyncio.Event().wait()


try:
    asyncio.run(main())
except KeyboardInterrupt:
    pass
