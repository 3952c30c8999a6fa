# The node is never spun.
# says: node '/talker' was never spun, so its callbacks never ran (1 timer): call rclpy.spin(node) after you have made it
import rclpy
from rclpy.node import Node


class Talker(Node):
    def __init__(self):
        super().__init__('talker')  # <-- here
        self.create_timer(0.5, self.talk)

    def talk(self):
        print('hello')


def main():
    rclpy.init()
    node = Talker()
    node.destroy_node()
    rclpy.shutdown()


main()
