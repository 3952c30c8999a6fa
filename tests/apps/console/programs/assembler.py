"""Prints what it is sent, as JSON: the service /fill, the action /assemble, and the topic /place."""

import asyncio
import json

from console_interfaces.action import Assemble
from console_interfaces.srv import Fill
from geometry_msgs.msg import PoseStamped
from rosidl_runtime_py import message_to_ordereddict

import goalwire


def heard(what, message):
    print(what, json.dumps(message_to_ordereddict(message)), flush=True)
    return getattr(message, 'name', '')


async def fill(request):
    return Fill.Response(heard=heard('service', request))


async def assemble(goal):
    goal.feedback(progress=1.0)
    return Assemble.Result(heard=heard('goal', goal.request))


async def main():
    async with goalwire.Node('assembler') as node:
        node.service(Fill, 'fill', fill)
        node.action_server(Assemble, 'assemble', assemble)
        places = node.subscription(PoseStamped, 'place')
        print('ready', flush=True)
        async for place in places:
            heard('topic', place)


asyncio.run(main())
