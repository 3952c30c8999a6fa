# A clock's time is given as a stamp.
# says: std_msgs/msg/Header: stamp: expected builtin_interfaces/msg/Time, got a Time of rclpy: write .to_msg() behind it where the program sets this field, as in stamp=node.get_clock().now().to_msg()
import rclpy
from std_msgs.msg import Header

rclpy.init()
node = rclpy.create_node('camera')
publisher = node.create_publisher(Header, 'header', 10)
publisher.publish(Header(stamp=node.get_clock().now()))  # <-- here
