# The callback of a service takes the request alone.
# says: the callback of the service 'battery' is called as answer(request, response), and does not take that: write 'def answer(request, response):'; the call will fail
import rclpy
from std_srvs.srv import Trigger


def answer(request):  # <-- here
    return Trigger.Response()


rclpy.init()
node = rclpy.create_node('power')
node.create_service(Trigger, 'battery', answer)
