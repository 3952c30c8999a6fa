# A parameter gets a dictionary.
# says: a parameter is a bool, int, float or str, bytes, or a list of one of these; declare a parameter for each item, named with a dot as in 'gains.p'
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('gains', {'p': 1.0, 'i': 0.1})  # <-- here
