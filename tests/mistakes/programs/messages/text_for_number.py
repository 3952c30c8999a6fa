# A number gets a text.
# says: std_msgs/msg/Int32: data: expected int, got str '5' (write 5)
import rclpy
from std_msgs.msg import Int32

rclpy.init()
node = rclpy.create_node('counter')
publisher = node.create_publisher(Int32, 'count', 10)
publisher.publish(Int32(data='5'))  # <-- here
