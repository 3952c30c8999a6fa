# A parameter is declared without a value, and read.
# says: declaring a parameter only providing its name is deprecated. Give a default value, a type (Parameter.Type.…), or a descriptor with dynamic_typing=True as well
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed')  # <-- here
