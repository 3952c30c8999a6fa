# A number is too large for its field.
# says: std_msgs/msg/UInt8: data: 300 is outside the range of uint8, [0, 255] (write a number from 0 to 255, or take a type with a larger range)
import rclpy
from std_msgs.msg import UInt8

rclpy.init()
node = rclpy.create_node('counter')
publisher = node.create_publisher(UInt8, 'count', 10)
publisher.publish(UInt8(data=300))  # <-- here
