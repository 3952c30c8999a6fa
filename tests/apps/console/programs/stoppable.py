"""A robot with an emergency stop that says how it stands: `stoppable.py URDF NAMESPACE X`.

It stands at X on the floor, moves its head, and has the frames of its namespace. `emergency_stop` is a
SetBool. A parameter `deaf` makes that answer nothing, `lying` makes it answer and not stop.
"""

import asyncio
import sys
from pathlib import Path

from console_interfaces.action import GoTo
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import BatteryState, JointState
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage

import goalwire

PERIOD_S = 0.05


class Robot:
    def __init__(self, node, x):
        self.node = node
        self.x, self.y, self.stopped = x, 0.0, False
        latched = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        self.state = node.publisher(Bool, 'emergency_stopped', qos=latched)
        self.status = node.publisher(DiagnosticStatus, 'emergency_stop_status', qos=latched)

    def tell(self):
        self.state.publish(data=self.stopped)
        values = [KeyValue(key='stopped', value=str(self.stopped).lower())]
        if not self.stopped:
            self.status.publish(message='released', values=values)
            return
        values.append(KeyValue(key='by', value='/operator'))
        self.status.publish(
            level=DiagnosticStatus.ERROR, message='/operator called the service', values=values
        )

    async def stop(self, request):
        print(f'{self.node.name}: asked {request.data}', flush=True)
        if self.node.parameters['deaf']:
            await asyncio.Event().wait()
        if not self.node.parameters['lying']:
            self.stopped = request.data
            self.tell()
        return SetBool.Response(success=True, message='stopped' if request.data else 'released')

    async def go(self, goal):
        print(f'{self.node.name}: goes to {goal.request.x:.1f}', flush=True)
        self.x, self.y = goal.request.x, goal.request.y
        return GoTo.Result(arrived=True)


async def main(urdf, namespace, x):
    prefix = f'{namespace}/' if namespace else ''
    node = goalwire.Node('robot', namespace=f'/{namespace}')
    async with node:
        latched = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        for name in ('deaf', 'lying'):
            node.parameters.declare(name, False)
        node.parameters.declare('frame_prefix', prefix)
        description = node.publisher(String, 'robot_description', qos=latched)
        description.publish(data=urdf)
        joints, frames = node.publisher(JointState, 'joint_states'), node.publisher(TFMessage, '/tf')
        battery = node.publisher(BatteryState, 'battery')
        robot = Robot(node, x)
        node.service(SetBool, 'emergency_stop', robot.stop, concurrent=True)
        node.action_server(GoTo, 'go_to', robot.go)
        robot.tell()
        print('ready', flush=True)
        tick = 0
        async for _ in node.timer(PERIOD_S):
            tick += 1
            if tick % 4 == 0:
                robot.state.publish(data=robot.stopped)
            joints.publish(name=['head_joint'], position=[0.0])
            poses = []
            for parent, child, place in (
                ('map', f'{prefix}base_link', (robot.x, robot.y, 0.0)),
                (f'{prefix}mast', f'{prefix}head', (0.0, 0.0, 0.3 + 0.05 * (tick % 20) / 20)),
            ):
                pose = TransformStamped()
                pose.header.frame_id, pose.child_frame_id = parent, child
                t = pose.transform.translation
                t.x, t.y, t.z = place
                poses.append(pose)
            frames.publish(transforms=poses)
            battery.publish(percentage=0.62 if namespace != 'bob' else 0.31)


asyncio.run(main(Path(sys.argv[1]).read_text(encoding='utf-8'), sys.argv[2], float(sys.argv[3])))
