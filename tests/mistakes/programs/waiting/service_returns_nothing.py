# The callback of a service returns nothing.
# says: return the Trigger_Response that it was given: write 'return response' (service_returns_nothing.py:7)), so the future stays pending
import rclpy
from std_srvs.srv import Trigger


def answer(request, response):  # <-- here
    response.success = True


rclpy.init()
node = rclpy.create_node('power')
node.create_service(Trigger, 'battery', answer)
client = node.create_client(Trigger, 'battery')
rclpy.spin_until_future_complete(node, client.call_async(Trigger.Request()))
