# The callback of a subscription takes no message.
# says: the callback of a subscription is a function that is callable with one argument, the message, or with two, the message and its info; hear takes another number: write 'def hear(message):'
import rclpy
from std_msgs.msg import String


def hear():
    print('heard')


rclpy.init()
node = rclpy.create_node('listener')
node.create_subscription(String, 'chatter', hear, 10)  # <-- here
