# A remapping is given without --ros-args.
# arguments: chatter:=talk
# says: Found remap rule 'chatter:=talk'. This syntax is deprecated. Use '--ros-args --remap chatter:=talk' instead.
# ctrl-c: yes
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(String, 'chatter', 10)
rclpy.spin(node)
