# The parameter file is for a node of another name.
# arguments: --ros-args --params-file walker.yaml
# says: nothing used '--params-file walker.yaml': it is for walker; this program made /driver: give both the same name
# within: 5 s
# ctrl-c: yes
import pathlib

import rclpy

pathlib.Path('walker.yaml').write_text('walker:\n  ros__parameters:\n    speed: 2.0\n')
rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
rclpy.spin(node)
