# A callback waits for the keyboard.
# says: the callback Robot.ask() has not returned for seconds (it is at: input('go on? ')), and other callbacks wait for it: let it return, and do the rest in a timer, self.create_timer(seconds, self.rest), or in a thread, threading.Thread(target=self.rest).start(); or spin with a MultiThreadedExecutor and give it callback_group=MutuallyExclusiveCallbackGroup()
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
