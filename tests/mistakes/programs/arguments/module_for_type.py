# The module is given and not the class.
# says: a class of a message, a service or an action is needed: std_msgs.msg is a module: give a class of it, such as std_msgs.msg.Bool
import rclpy
import std_msgs.msg

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(std_msgs.msg, 'chatter', 10)  # <-- here
