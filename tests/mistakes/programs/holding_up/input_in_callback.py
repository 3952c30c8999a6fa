# A callback waits for the keyboard.
# says: the callback Robot.ask() has not returned for seconds, and other callbacks wait for it: let it return, and do the rest in a timer or in a thread; or spin with a MultiThreadedExecutor and give it a callback group of its own
# within: 5 s
# ctrl-c: yes
import rclpy
from rclpy.node import Node


class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.create_timer(0.1, self.watch)
        self.create_timer(0.2, self.ask)

    def watch(self):
        pass

    def ask(self):
        input('go on? ')  # <-- here


rclpy.init()
rclpy.spin(Robot())
