# A parameter is declared without a value, and read.
# says: declaring a parameter only providing its name is deprecated. Write declare_parameter('speed', 1.0) with its default value; or, without one, declare_parameter('speed', Parameter.Type.DOUBLE), from rclpy.parameter
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed')  # <-- here
