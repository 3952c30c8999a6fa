"""An ordinary node, typed: each thing that a node does once."""

from __future__ import annotations

import rclpy
from example_interfaces.action import Fibonacci
from geometry_msgs.msg import PoseStamped, Twist
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.action.client import ClientGoalHandle
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.client import Client
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.task import Future
from rclpy.time import Time
from rclpy.timer import Timer
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import Float64MultiArray, Header, String
from std_srvs.srv import SetBool, Trigger


class Robot(Node):
    def __init__(self) -> None:
        super().__init__('robot', namespace='left', allow_undeclared_parameters=True)
        self.declare_parameter('speed', 1.0)
        self.declare_parameter('names', ['a', 'b'])
        self.declare_parameter('empty', [])
        self.declare_parameter('typed', Parameter.Type.INTEGER)
        self.declare_parameter('described', 3, ParameterDescriptor(description='how often'))
        self.declare_parameters('arm', [('length', 0.5), ('joints', 6)])
        self.speed: float = self.get_parameter('speed').value
        self.names: list[str] = self.get_parameter('names').get_parameter_value().string_array_value
        period = 1.0 / self.speed
        count = self.get_parameter('typed').value + 1
        self.get_logger().info(f'{period:.1f} {count}', throttle_duration_sec=1.0)
        self.add_on_set_parameters_callback(self.on_parameters)
        profile = QoSProfile(
            depth=10, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE
        )
        group = ReentrantCallbackGroup()
        self.velocity: Publisher[Twist] = self.create_publisher(Twist, 'cmd_vel', 10)
        self.text = self.create_publisher(String, 'text', profile, callback_group=group)
        self.joints: Subscription[JointState] = self.create_subscription(
            JointState, 'joint_states', self.on_joints, profile
        )
        self.create_subscription(Image, 'image', lambda image: None, 1)
        self.timer: Timer = self.create_timer(
            period, self.tick, callback_group=MutuallyExclusiveCallbackGroup()
        )
        self.service: Service = self.create_service(SetBool, 'switch', self.on_switch)
        self.client: Client = self.create_client(Trigger, 'reset', callback_group=group)
        self.counter = ActionServer(
            self,
            Fibonacci,
            'count',
            self.execute,
            goal_callback=lambda request: GoalResponse.ACCEPT,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            callback_group=group,
        )
        self.asker = ActionClient(self, Fibonacci, 'count')
        self.last: Time = self.get_clock().now()

    def on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == 'speed' and parameter.type_ == Parameter.Type.DOUBLE:
                self.speed = parameter.value
        return SetParametersResult(successful=True, reason='')

    def on_joints(self, message: JointState) -> None:
        for name, position in zip(message.name, message.position, strict=True):
            self.get_logger().debug(name + f' {position:.2f}')
        message.position[0] = 1.0
        message.velocity = [0.0] * len(message.name)
        message.header.stamp = self.get_clock().now().to_msg()
        array = Float64MultiArray(data=[1.0, 2.0])
        array.data.append(sum(message.position))

    def tick(self) -> None:
        now = self.get_clock().now()
        if now - self.last > Duration(seconds=2):
            self.last = now
        age: float = (now - Time.from_msg(Header().stamp)).nanoseconds * 1e-9
        twist = Twist()
        twist.linear.x = self.speed * age
        self.velocity.publish(twist)
        self.text.publish(String(data='tick'))
        pose = PoseStamped(header=Header(frame_id='map', stamp=now.to_msg()))
        pose.pose.orientation.w = 1.0
        future = self.client.call_async(Trigger.Request())
        future.add_done_callback(self.on_reset)

    def on_reset(self, future: Future) -> None:
        self.get_logger().info(future.result().message)

    def on_switch(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = request.data
        return response

    def execute(self, goal: ServerGoalHandle) -> Fibonacci.Result:
        feedback = Fibonacci.Feedback(sequence=[0, 1])
        for _ in range(goal.request.order):
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result()
            feedback.sequence.append(feedback.sequence[-1] + feedback.sequence[-2])
            goal.publish_feedback(feedback)
        goal.succeed()
        return Fibonacci.Result(sequence=feedback.sequence)

    async def ask(self) -> list[int]:
        handle: ClientGoalHandle = await self.asker.send_goal_async(Fibonacci.Goal(order=5))
        if not handle.accepted:
            return []
        answer = await handle.get_result_async()
        return list(answer.result.sequence)


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    node = Robot()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(node)
    client = node.create_client(SetBool, 'switch')
    if not client.wait_for_service(timeout_sec=1.0):
        node.get_logger().warning('nobody')
    future = client.call_async(SetBool.Request(data=True))
    rclpy.spin_until_future_complete(node, future, timeout_sec=5.0)
    print(future.result().message, client.call(SetBool.Request()).success)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
