# The request's class is given and not a request.
# says: expected std_srvs.srv.Trigger.Request, got the class: write Trigger.Request(), with the parentheses
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('asker')
client = node.create_client(Trigger, 'battery')
client.call_async(Trigger.Request)  # <-- here
