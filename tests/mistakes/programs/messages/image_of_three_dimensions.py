# An image's data is an array of rows, columns and colours.
# says: The 'data' field: a list of numbers has one dimension, this array has 3: write data=….ravel()
import numpy as np
import rclpy
from sensor_msgs.msg import Image

rclpy.init()
node = rclpy.create_node('camera')
publisher = node.create_publisher(Image, 'image', 10)
picture = np.zeros((4, 6, 3), dtype=np.uint8)
publisher.publish(Image(height=4, width=6, encoding='rgb8', step=18, data=picture))  # <-- here
