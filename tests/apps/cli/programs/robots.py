"""Three robots, alpha, albert and beta, in one process: an action, a topic and a battery each."""

import asyncio
from contextlib import suppress

from example_interfaces.action import Fibonacci
from sensor_msgs.msg import BatteryState
from std_msgs.msg import String

import goalwire

KEPT = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)


async def drive(goal):
    try:
        if goal.request.order == 0:
            print('drives', flush=True)
            await asyncio.Event().wait()
        if goal.request.order == 13:
            raise goalwire.GoalAborted('an unlucky number')
    except asyncio.CancelledError:
        print('stopped', flush=True)
        raise
    return Fibonacci.Result(sequence=[goal.request.order])


async def serve(name, ready):
    async with goalwire.Node('driver', namespace=f'/{name}') as node:
        node.action_server(Fibonacci, 'drive', drive)
        node.publisher(BatteryState, 'battery_state', qos=KEPT).publish(percentage=0.5)
        text = node.publisher(String, 'text', qos=KEPT)
        text.publish(data=f'I am {name}')
        await ready.wait()
        await asyncio.Event().wait()


async def main():
    ready = asyncio.Barrier(4)
    async with asyncio.TaskGroup() as group:
        for name in ('alpha', 'albert', 'beta'):
            group.create_task(serve(name, ready))
        await ready.wait()
        print('ready', flush=True)


with suppress(KeyboardInterrupt):
    asyncio.run(main())
