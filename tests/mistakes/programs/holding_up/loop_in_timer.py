# A timer's callback loops until another callback sets a flag.
# says: and other callbacks wait for it: let it return, and do the rest in a timer, self.create_timer(seconds, self.rest), or in a thread, threading.Thread(target=self.rest).start(); or spin with a MultiThreadedExecutor and give it callback_group=MutuallyExclusiveCallbackGroup()
# within: 5 s
# ctrl-c: yes
import rclpy
from rclpy.node import Node
from std_msgs.msg import Bool


class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.pressed = False
        self.create_subscription(Bool, 'button', self.press, 10)
        self.publisher = self.create_publisher(Bool, 'button', 10)
        self.create_timer(0.1, self.send)
        self.create_timer(0.3, self.work)

    def send(self):
        self.publisher.publish(Bool(data=True))

    def press(self, message):
        self.pressed = False

    def work(self):
        while not self.pressed:  # <-- here
            pass


rclpy.init()
rclpy.spin(Robot())
