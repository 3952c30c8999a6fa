# A clock's time is given as a stamp.
# says: (write the same with .to_msg() behind it)
import rclpy
from std_msgs.msg import Header

rclpy.init()
node = rclpy.create_node('camera')
publisher = node.create_publisher(Header, 'header', 10)
publisher.publish(Header(stamp=node.get_clock().now()))  # <-- here
