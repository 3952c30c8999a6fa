# A parameter gets a list of floats and whole numbers.
# says: give all items the same type, such as [1.0, 2.0] and not [1.0, 2]
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('gains', [1.0, 2, 3.5])  # <-- here
