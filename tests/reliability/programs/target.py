"""A node that strangers attack: it adds, sends large answers, and keeps a latched message."""

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

PICTURE = 'x' * (1 << 20)


class Target(Node):
    def __init__(self) -> None:
        super().__init__('target')
        self.create_service(AddTwoInts, 'add', self.add)
        self.create_service(Trigger, 'picture', self.show)
        lasting = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.map = self.create_publisher(String, 'map', lasting)
        self.map.publish(String(data='map'))
        print('ready')

    def add(self, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        return response

    def show(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = PICTURE
        return response


if __name__ == '__main__':
    try:
        with rclpy.init():
            rclpy.spin(Target())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
