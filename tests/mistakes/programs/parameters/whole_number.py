# A whole number is given for a parameter that is a float.
# arguments: --ros-args -p speed:=1
# says: speed: give 1.0, not 1 (double) where its value comes from: -p, a parameter file or parameter_overrides
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)  # <-- here
