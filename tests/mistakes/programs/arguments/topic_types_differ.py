# Publisher and subscription of a topic have different types.
# says: Incompatible type on topic '/chatter', no messages will be sent to it: publisher in node '/talker' has the type std_msgs/msg/String and subscription in node '/talker' has the type std_msgs/msg/Int32; give both the same type, or give one of them another name
# ctrl-c: yes
import rclpy
from std_msgs.msg import Int32, String

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(String, 'chatter', 10)
node.create_subscription(Int32, 'chatter', print, 10)  # <-- here
rclpy.spin(node)
