# A number is added to a time.
# says: unsupported operand type(s) for +: 'Time' and 'int' write Duration(seconds=…), from rclpy.duration, in place of the number
import rclpy

rclpy.init()
node = rclpy.create_node('talker')
later = node.get_clock().now() + 5  # <-- here
