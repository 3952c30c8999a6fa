# An array of fixed length gets too few numbers.
# says: sensor_msgs/msg/Imu: orientation_covariance: expected exactly 9 values, got 3 (write a list of 9 values, or leave the field out)
import rclpy
from sensor_msgs.msg import Imu

rclpy.init()
node = rclpy.create_node('imu')
publisher = node.create_publisher(Imu, 'imu', 10)
publisher.publish(Imu(orientation_covariance=[0.0, 0.0, 0.0]))  # <-- here
