# Two nodes are made, and only one of them is spun.
# says: node '/right' was never spun, so its callbacks never ran (1 timer): rclpy.spin() runs one node and does not return: write executor = SingleThreadedExecutor(), executor.add_node(…) for each node, and executor.spin()
# within: 5 s
# ctrl-c: yes
import rclpy
from rclpy.node import Node


class Blinker(Node):
    def __init__(self, name):
        super().__init__(name)  # <-- here
        self.create_timer(0.2, self.blink)

    def blink(self):
        pass


rclpy.init()
left = Blinker('left')
right = Blinker('right')
rclpy.spin(left)
