"""A camera, and a viewer that requests more than the camera offers."""

import rclpy
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import String

rclpy.init()
camera, viewer = rclpy.create_node('camera'), rclpy.create_node('viewer')
camera.create_publisher(String, 'image', qos_profile_sensor_data)
viewer.create_subscription(String, 'image', print, 10)
print('ready', flush=True)
rclpy.spin(camera)
