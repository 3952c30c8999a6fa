"""A server that is asked and does not answer."""

from threading import Event

import rclpy
from std_srvs.srv import Trigger


def wait(request, response):
    print('asked', flush=True)
    Event().wait()


rclpy.init()
node = rclpy.create_node('lonely')
node.create_service(Trigger, 'lonely', wait)
print('ready', flush=True)
rclpy.spin(node)
