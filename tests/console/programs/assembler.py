"""Prints what it is sent, as JSON: the service /fill and the action /assemble."""

import asyncio
import json

from console_interfaces.action import Assemble
from console_interfaces.srv import Fill
from rosidl_runtime_py import message_to_ordereddict

import goalwire


def heard(what, message):
    print(what, json.dumps(message_to_ordereddict(message)), flush=True)
    return message.name


async def fill(request):
    return Fill.Response(heard=heard('service', request))


async def assemble(goal):
    goal.feedback(progress=1.0)
    return Assemble.Result(heard=heard('goal', goal.request))


async def main():
    async with goalwire.Node('assembler') as node:
        node.service(Fill, 'fill', fill)
        node.action_server(Assemble, 'assemble', assemble)
        print('ready', flush=True)
        await asyncio.Event().wait()


asyncio.run(main())
