# A parameter is read that was not declared.
# says: Invalid access to undeclared parameter(s): sped did you mean 'speed'?
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
print(node.get_parameter('sped').value)  # <-- here
