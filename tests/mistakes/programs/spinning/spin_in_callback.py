# rclpy.spin() is called in a callback.
# says: rclpy.spin() was called in a callback, and never returns: remove this call; the program already spins, and goes on after the callback has returned. To wait for one answer, write 'await future' in an 'async def'
# ctrl-c: yes
import rclpy
from rclpy.node import Node


class Talker(Node):
    def __init__(self):
        super().__init__('talker')
        self.create_timer(0.1, self.talk)

    def talk(self):
        rclpy.spin(self)  # <-- here


rclpy.init()
rclpy.spin(Talker())
