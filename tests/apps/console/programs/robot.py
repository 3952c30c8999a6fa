"""A robot for the console: it stands at the origin, goes where it is sent, waves, speaks, and can be stopped.

Arguments: the file of its URDF. Its program `mischief` has what does not go together.
"""

import asyncio
import math
import sys
from pathlib import Path

from console_interfaces.action import GoTo
from control_msgs.action import FollowJointTrajectory
from example_interfaces.action import Fibonacci
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, Twist
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from sensor_msgs.msg import BatteryState, Image, JointState
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory

import goalwire

PERIOD_S = 0.05


class Robot:
    def __init__(self, node):
        self.node = node
        self.x = self.y = self.clock = 0.0
        self.stopped = self.mute = False
        self.head = None
        self.asked = 0
        self.driven = None

    async def go(self, goal):
        target = goal.request.x, goal.request.y
        while not self.stopped:
            left = math.dist((self.x, self.y), target)
            goal.feedback(distance_remaining=left)
            if left < 0.02:
                return GoTo.Result(arrived=True)
            step = min(goal.request.speed * PERIOD_S, left)
            self.x += (target[0] - self.x) / left * step
            self.y += (target[1] - self.y) / left * step
            await asyncio.sleep(PERIOD_S)
        raise goalwire.GoalAborted('stopped', result=GoTo.Result(arrived=False))

    async def count(self, goal):
        numbers = [0, 1]
        for _ in range(goal.request.order if goal.request.order < 90 else 1_000_000):  # until it is cancelled
            numbers.append((numbers[-1] + numbers[-2]) % 1000)
            goal.feedback(sequence=numbers)
            await asyncio.sleep(0.2)
        return Fibonacci.Result(sequence=numbers)

    async def follow(self, goal):
        self.move(goal.request.trajectory, 'goal')
        return FollowJointTrajectory.Result()

    def move(self, trajectory, way):
        [name], [point] = trajectory.joint_names, trajectory.points
        self.head = point.positions[0]
        print(f'{way}: {name} to {self.head:.2f}', flush=True)

    def drive(self, message):
        driven = message.linear.x, message.angular.z
        if driven != self.driven:
            self.driven = driven
            print('driven {:.2f} {:.2f}'.format(*driven), flush=True)

    def guess(self, message):
        pose = message.pose.pose
        degrees = math.degrees(2 * math.atan2(pose.orientation.z, pose.orientation.w))
        print(f'told {pose.position.x:.1f} {pose.position.y:.1f} {degrees:.0f}', flush=True)

    async def listen(self, subscription, heard):
        async for message in subscription:
            heard(message)

    async def shy(self, _request):
        self.asked += 1
        if self.asked % 2:
            await asyncio.Event().wait()  # only each second request is answered
        return Trigger.Response(success=True, message=f'answer to request {self.asked}')

    async def deaf(self, _request):
        await asyncio.Event().wait()

    async def stop(self, _request):
        self.stopped = True
        self.node.logger.error('emergency stop')
        print('stopped', flush=True)
        return Trigger.Response(success=True, message='stopped')

    async def hush(self, request):
        self.mute = request.data
        return SetBool.Response(success=True)

    async def lamp(self, request):
        print('lamp', request.data, flush=True)
        return SetBool.Response(success=True, message='on <b>and bright</b>' if request.data else 'off')


async def main(urdf):
    node = goalwire.Node('robot')
    async with node, goalwire.Node('mischief') as mischief:
        robot = Robot(node)
        unreliable = goalwire.ReliabilityPolicy.BEST_EFFORT
        latched = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        description = node.publisher(String, 'robot_description', qos=latched)
        description.publish(data=urdf)
        joints, frames = node.publisher(JointState, 'joint_states'), node.publisher(TFMessage, 'tf')
        battery, load = node.publisher(BatteryState, 'battery'), node.publisher(Float64, 'load')
        camera = node.publisher(Image, 'camera')
        node.parameters.declare('greeting', 'hello')
        bounds = [FloatingPointRange(from_value=0.0, to_value=2.0)]
        node.parameters.declare(
            'speed', 0.5, descriptor=ParameterDescriptor(description='m/s', floating_point_range=bounds)
        )
        steps = [IntegerRange(from_value=0, to_value=100, step=10)]
        node.parameters.declare(
            'volume', 50, descriptor=ParameterDescriptor(description='loudness', integer_range=steps)
        )
        fixed = ParameterDescriptor(description='on the plate', read_only=True)
        node.parameters.declare('serial', 'A-17', descriptor=fixed)
        node.service(Trigger, 'shy', robot.shy, concurrent=True)
        node.service(Trigger, 'deaf', robot.deaf, concurrent=True)
        node.action_server(FollowJointTrajectory, 'arm/follow', robot.follow)
        loop = asyncio.get_running_loop()
        listening = [
            loop.create_task(robot.listen(node.subscription(cls, topic), heard))
            for cls, topic, heard in (
                (JointTrajectory, 'arm/trajectory', lambda message: robot.move(message, 'message')),
                (Twist, 'cmd_vel', robot.drive),
                (PoseWithCovarianceStamped, 'initialpose', robot.guess),
                (String, 'say', lambda message: print(f'said {message.data!r}', flush=True)),
            )
        ]
        node.service(Trigger, 'estop', robot.stop)
        node.service(SetBool, 'lamp', robot.lamp)
        node.service(SetBool, 'hush', robot.hush)
        node.action_server(GoTo, 'go_to', robot.go)
        node.action_server(Fibonacci, 'count', robot.count, accept=lambda goal: goal.order < 100)
        mischief.publisher(String, 'quarrel')
        mischief.subscription(Float64, 'quarrel')
        mischief.publisher(String, 'whisper', qos=goalwire.QoS(reliability=unreliable))
        mischief.subscription(String, 'whisper', qos=10)
        mischief.logger.warning('half of this is <b>wrong</b>')
        node.logger.info('<script>window.hacked = 1</script><img src=x onerror="window.hacked = 1">')
        texts = node.publisher(String, 'texts', qos=latched)
        texts.publish(data='<script>window.hacked = 1</script> javascript:window.hacked=1')
        print('ready', len(listening), flush=True)
        async for _ in node.timer(PERIOD_S):
            if robot.mute:
                continue
            if not robot.stopped:
                robot.clock += PERIOD_S
            waving = 0.8 * math.sin(2 * robot.clock)
            head = 0.5 * waving if robot.head is None else robot.head
            joints.publish(name=['left_joint', 'head_joint'], position=[waving, head])
            pose = TransformStamped()
            pose.header.frame_id, pose.child_frame_id = 'odom', 'base_link'
            pose.transform.translation.x, pose.transform.translation.y = robot.x, robot.y
            frames.publish(transforms=[pose])
            battery.publish(percentage=0.62)
            load.publish(data=3.0 + waving)
            if round(robot.clock / PERIOD_S) % 10 == 1:
                camera.publish(
                    height=48, width=64, encoding='rgb8', step=192, data=bytes([200, 60, 20]) * 3072
                )


asyncio.run(main(Path(sys.argv[1]).read_text(encoding='utf-8')))
