"""A node that strangers attack: it adds, sends large answers, hears a latched topic, subscribes anew."""

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

PICTURE = 'x' * (1 << 20)
LASTING = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Target(Node):
    def __init__(self) -> None:
        super().__init__('target')
        self.beats: set[str] = set()
        self.create_service(AddTwoInts, 'add', self.add)
        self.create_service(Trigger, 'picture', self.show)
        self.create_service(Trigger, 'heard', self.tell)
        self.create_subscription(String, 'beat', lambda beat: self.beats.add(beat.data), LASTING)
        self.map = self.create_publisher(String, 'map', LASTING)
        self.map.publish(String(data='map'))
        # More than one of a hundred calls waits for it. So the others' p99 shows what a subscription costs.
        self.create_timer(0.05, self.look)
        print('ready')

    def add(self, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        return response

    def show(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = PICTURE
        return response

    def tell(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Tell which of the other client's messages have come since the last time."""
        response.message = ' '.join(self.beats - {'forged'})
        self.beats.clear()
        return response

    def look(self) -> None:
        self.destroy_subscription(self.create_subscription(String, 'looked_at', print, 10))


if __name__ == '__main__':
    try:
        with rclpy.init():
            rclpy.spin(Target())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
