"""Offers the action `fibonacci`: one number every half second. Its other half is fibonacci_action_client.py.

python examples/asyncio/fibonacci_action_server.py
"""

import asyncio

from example_interfaces.action import Fibonacci

import goalwire

STEP_S = 0.5
LARGEST_ORDER = 46  # the next number does not fit an int32


async def count(goal):
    sequence = [0, 1]
    while len(sequence) <= goal.request.order:
        sequence.append(sequence[-1] + sequence[-2])
        goal.feedback(sequence=sequence)
        await asyncio.sleep(STEP_S)  # where a cancelled goal ends
    return Fibonacci.Result(sequence=sequence)


async def main():
    async with goalwire.Node('fibonacci_action_server') as node:
        node.action_server(Fibonacci, 'fibonacci', count, accept=lambda goal: 0 < goal.order <= LARGEST_ORDER)
        node.logger.info('Ready to count')
        await asyncio.Event().wait()


try:
    asyncio.run(main())
except KeyboardInterrupt:
    pass
