# A parameter's name is misspelt on the command line.
# arguments: --ros-args -p sped:=2.0
# says: nothing used '-p sped:=…': /driver did not declare sped; did you mean speed?
# within: 5 s
# ctrl-c: yes
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
rclpy.spin(node)
