"""Sends a goal to the action `fibonacci` and follows it to its end. Other half: fibonacci_action_server.py.

python examples/asyncio/fibonacci_action_client.py 8
python examples/asyncio/fibonacci_action_client.py 8 2     # for 2 seconds at most

Ctrl-C cancels the goal, too.
"""

import asyncio
import sys

from example_interfaces.action import Fibonacci

import goalwire


async def main(order, seconds=None):
    async with goalwire.Node('fibonacci_action_client') as node:
        async with node.action(Fibonacci, 'fibonacci').send(order=int(order), timeout=seconds) as run:
            async for feedback in run.feedback:
                print(f'So far: {list(feedback.sequence)}')
            result = await run.result
        print(f'Result: {list(result.sequence)}')


try:
    asyncio.run(main(sys.argv[1], *map(float, sys.argv[2:3])))
except goalwire.CallError as error:
    sys.exit(str(error))
except KeyboardInterrupt:
    sys.exit('Cancelled')
