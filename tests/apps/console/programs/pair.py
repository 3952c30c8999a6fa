"""Three robots with a box each: alice and bob in the frame `world`, and carol in `attic`, apart from it."""

import asyncio

from geometry_msgs.msg import TransformStamped
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

import goalwire

LATCHED = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
BOX = """<robot name="box"><link name="base"><visual><origin xyz="0 0 0.2"/>
<geometry><box size="0.8 0.8 0.4"/></geometry>
<material name="red"><color rgba="1 0 0 1"/></material></visual></link></robot>"""


def at(parent, child, x):
    frame = TransformStamped()
    frame.header.frame_id, frame.child_frame_id = parent, child
    frame.transform.translation.x = x
    return frame


async def main():
    async with goalwire.Node('pair') as node:
        for name in ('alice', 'bob', 'carol'):
            node.publisher(String, f'/{name}/robot_description', qos=LATCHED).publish(data=BOX)
        frames = node.publisher(TFMessage, '/tf')
        print('ready', flush=True)
        async for _ in node.timer(0.1):
            frames.publish(
                transforms=[
                    at('world', 'alice/base', 0.0),
                    at('world', 'bob/base', 1.5),
                    at('attic', 'carol/base', 3.0),
                ]
            )


asyncio.run(main())
