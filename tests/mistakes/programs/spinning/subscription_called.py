# The subscription gets the result of the function.
# says: the callback of a subscription is a function that is callable with one argument, the message: got None; give the function itself, f and not f()
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('listener')


def heard(message=None):
    print(message)


node.create_subscription(String, 'chatter', heard(), 10)  # <-- here
