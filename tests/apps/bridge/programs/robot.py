"""A robot for clients of bridges: it says what it is told, adds, counts, and has a parameter."""

import asyncio

from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from sensor_msgs.msg import Image
from std_msgs.msg import Float64MultiArray, String

import goalwire


async def count(goal):
    sequence = [0, 1]
    try:
        for at in range(1, goal.request.order):
            sequence.append((sequence[at] + sequence[at - 1]) % 2**31)
            goal.feedback(sequence=sequence)
            await asyncio.sleep(0.01)
    except asyncio.CancelledError:
        print('cancelled', flush=True)
        raise
    return Fibonacci.Result(sequence=sequence)


async def main():
    async with goalwire.Node('robot') as node:
        node.parameters.declare('speed', 0.5)
        node.service(AddTwoInts, '/add', lambda request: AddTwoInts.Response(sum=request.a + request.b))
        node.action_server(Fibonacci, '/fibonacci', count)
        latched = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        node.publisher(String, '/robot_description', qos=latched).publish(data='a robot')
        pictures = node.publisher(Image, '/picture')
        numbers = node.publisher(Float64MultiArray, '/numbers')
        heard = node.subscription(String, '/say', qos=100)
        print('ready', flush=True)
        async for message in heard:
            print('heard', message.data, flush=True)
            pictures.publish(height=1, width=3, encoding='mono8', data=b'\x00\x7f\xff')
            numbers.publish(data=[1.5, float('nan'), float('inf')])


asyncio.run(main())
