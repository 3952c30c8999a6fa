# The service's class is given and not a request.
# says: Service classes can not be instantiated: Trigger only holds its parts; write Trigger.Request()
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('asker')
client = node.create_client(Trigger, 'battery')
client.call_async(Trigger())  # <-- here
