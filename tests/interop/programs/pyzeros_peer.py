"""pyzeros as an echo, a service server or a service client, as its first argument says."""

import asyncio
import json
import os
import sys

import zenoh
from asyncio_for_robotics import Scope  # type: ignore[import-not-found]
from pyzeros import Client, Pub, Server, Sub, auto_context  # type: ignore[import-not-found]
from pyzeros.builtin_msgs import Attachment  # type: ignore[import-not-found]
from ros2_pyterfaces.cyclone.all_msgs import String  # type: ignore[import-not-found]
from ros2_pyterfaces.cyclone.all_srvs import SetBool  # type: ignore[import-not-found]


async def echo() -> None:
    heard, said = Sub(String, 'to_peer'), Pub(String, 'from_peer')
    print('ready', flush=True)
    async for message in heard.listen_reliable():
        said.publish(String(data=f'echo of {message.data}'))


async def serve() -> None:
    server = Server(SetBool, 'switch')
    print('ready', flush=True)
    async for responder in server.listen_reliable():
        responder.response.success = True
        responder.response.message = 'it is on' if responder.request.data else 'it is off'
        responder.send()


async def call() -> None:
    client = Client(SetBool, 'switch')
    await client.wait_for_service()
    for on in (True, False):
        answer = await client.call_async(SetBool.Request(data=on))
        print(answer.success, answer.message, flush=True)


async def main(role: str) -> None:
    async with Scope():
        await {'echo': echo, 'serve': serve, 'call': call}[role]()


Attachment().serialize()  # compiled by a C compiler the first time, which takes many seconds
config = zenoh.Config()
config.insert_json5('scouting/multicast/enabled', 'false')
config.insert_json5('connect/endpoints', json.dumps([f'tcp/127.0.0.1:{os.environ["GOALWIRE_ROUTER_PORT"]}']))
with zenoh.open(config) as session, auto_context('pyzeros_peer', session, namespace='/'):
    asyncio.run(main(sys.argv[1]))
