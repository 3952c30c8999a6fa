"""Serves what `vendor_server.py` serves, on RustDDS by roswell; it is given a folder of definitions."""

import asyncio
import os
import sys
import threading
import time
from pathlib import Path

import roswell  # type: ignore[import-not-found]

node = roswell.Node('server', domain=int(os.environ['ROS_DOMAIN_ID']), type_paths=[Path(sys.argv[1])])
String = node.load_type('std_msgs/msg/String')
LARGEST = min(int(sys.argv[2]), 200_000)
DEEP = roswell.QosProfile(depth=100)
LATCHED = roswell.QosProfile(depth=1, durability='transient_local')


def say(publisher: roswell.Publisher, text: str) -> None:
    message = publisher.new()
    message.data = text
    publisher.publish(message)


def answer(request: roswell.Message) -> roswell.Message:
    response = SetBool[1].alloc()
    response.success = request.data
    response.message = 'long' * (LARGEST // 4) if request.data else 'short'
    return response


def count(goal: roswell.Message, handle: roswell.ServerGoalHandle) -> roswell.Message:
    numbers = [0, 1]
    for _ in range(goal.order - 1):
        if handle.is_cancel_requested:
            break
        numbers.append((numbers[-1] + numbers[-2]) % 2**31)
        feedback = handle.new_feedback()
        feedback.sequence = numbers
        handle.publish_feedback(feedback)
        time.sleep(0.02)
    result = handle.new_result()
    result.sequence = numbers
    return result


async def echo() -> None:
    async with node.subscribe('/ping', String, qos=DEEP) as pings:
        print('ready', flush=True)
        async for message in pings:
            say(pong, message.data)


node.declare_parameter('gain', 1.5)
SetBool = node.load_service('std_srvs/srv/SetBool')
service = node.serve('/set', SetBool, answer)
action = node.action_server('/count', 'example_interfaces/action/Fibonacci', count)
pong = node.publisher('/pong', String, qos=DEEP)
latched = node.publisher('/latched', String, qos=LATCHED)
say(latched, 'said before')
ways = [
    node.publisher(
        f'/qos_{reliability}_{durability}',
        String,
        qos=roswell.QosProfile(depth=1, reliability=reliability, durability=durability),
    )
    for reliability in ('reliable', 'best_effort')
    for durability in ('transient_local', 'volatile')
]


def speak() -> None:
    while True:
        for way in ways:
            say(way, 'spoken')
        time.sleep(0.05)


threading.Thread(target=speak, daemon=True).start()
try:
    asyncio.run(echo())
except KeyboardInterrupt:
    os._exit(0)
