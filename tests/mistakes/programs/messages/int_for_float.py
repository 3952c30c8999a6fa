# A float gets a whole number.
# says: std_msgs/msg/Float64: data: expected float, got int 1 (write 1.0)
import rclpy
from std_msgs.msg import Float64

rclpy.init()
node = rclpy.create_node('motor')
publisher = node.create_publisher(Float64, 'speed', 10)
publisher.publish(Float64(data=1))  # <-- here
