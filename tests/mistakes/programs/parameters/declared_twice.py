# A parameter is declared twice.
# says: Parameter(s) already declared: ['speed'] declare each once, or ask 'has_parameter()' before
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
node.declare_parameter('speed', 2.0)  # <-- here
