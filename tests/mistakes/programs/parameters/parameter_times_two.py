# The parameter is used as if it were its value.
# says: this is the parameter 'speed' and not its value: write get_parameter('speed').value
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
print(node.get_parameter('speed') * 2)  # <-- here
