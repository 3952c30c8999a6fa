# A bool gets a number.
# says: std_msgs/msg/Bool: data: expected bool, got int 3 (write True or False)
import rclpy
from std_msgs.msg import Bool

rclpy.init()
node = rclpy.create_node('button')
publisher = node.create_publisher(Bool, 'button', 10)
publisher.publish(Bool(data=3))  # <-- here
