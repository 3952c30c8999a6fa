# A list of numbers gets an array of two dimensions.
# says: The 'data' field: a list of numbers has one dimension, this array has 2: write data=….ravel()
import numpy as np
import rclpy
from std_msgs.msg import Float32MultiArray

rclpy.init()
node = rclpy.create_node('grid')
publisher = node.create_publisher(Float32MultiArray, 'grid', 10)
publisher.publish(Float32MultiArray(data=np.zeros((2, 3), dtype=np.float32)))  # <-- here
