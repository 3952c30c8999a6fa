"""A robot that lies on the floor until `get_up` is called, and says how it was pushed."""

import asyncio

from geometry_msgs.msg import TransformStamped
from humanoid_interfaces.srv import Push
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

import goalwire

LATCHED = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
URDF = '<robot name="tumbler"><link name="base_link"/></robot>'


def facing_left():
    frame = TransformStamped()
    frame.header.frame_id, frame.child_frame_id = 'odom', 'base_link'
    frame.transform.rotation.z = frame.transform.rotation.w = 0.5**0.5
    return frame


async def main():
    async with goalwire.Node('tumbler') as node:
        node.publisher(String, 'robot_description', qos=LATCHED).publish(data=URDF)
        fallen = node.publisher(Bool, 'fallen', qos=LATCHED)
        fallen.publish(data=True)

        def get_up(_request):
            fallen.publish(data=False)
            return Trigger.Response(success=True, message='it stands again')

        def push(request):
            force = request.force
            text = f'pushed by {force.x:.0f}, {force.y:.0f} N'
            return Push.Response(success=force.y < 100.0, message=text)

        node.service(Trigger, 'get_up', get_up)
        node.service(Push, 'push', push)
        frames = node.publisher(TFMessage, 'tf')
        print('ready', flush=True)
        async for _ in node.timer(0.1):
            frames.publish(transforms=[facing_left()])


asyncio.run(main())
