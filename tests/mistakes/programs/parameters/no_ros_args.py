# -p is given without --ros-args.
# arguments: -p speed:=2.0
# says: '-p speed:=2.0' has no effect: write --ros-args before it, as in '--ros-args -p speed:=2.0'
# ctrl-c: yes
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
rclpy.spin(node)
