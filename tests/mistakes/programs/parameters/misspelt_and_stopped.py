# A parameter's name is misspelt, and Ctrl-C ends the program soon.
# arguments: --ros-args -p sped:=2.0
# says: nothing used '-p sped:=…': /driver did not declare sped; did you mean speed?
import os
import signal

import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
node.create_timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))  # stands for the Ctrl-C
rclpy.spin(node)
