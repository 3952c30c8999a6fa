"""Asks the service `add_two_ints` for one sum. Its other half is add_two_ints_server.py.

python examples/asyncio/add_two_ints_client.py 2 3

Either may be started first: the call waits up to ten seconds for a server and its answer.
"""

import asyncio
import sys

from example_interfaces.srv import AddTwoInts

import goalwire


async def main(a, b):
    async with goalwire.Node('add_two_ints_client') as node:
        response = await node.client(AddTwoInts, 'add_two_ints').call(a=a, b=b, timeout=10.0)
        print(f'{a} + {b} = {response.sum}')


try:
    asyncio.run(main(*map(int, sys.argv[1:3])))
except goalwire.CallError as error:
    sys.exit(str(error))
