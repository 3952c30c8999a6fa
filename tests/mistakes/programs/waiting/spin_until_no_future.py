# spin_until_future_complete() gets the answer of call().
# says: spin_until_future_complete(node, future) waits for a future, not for std_srvs.srv.Trigger_Response(success=False, message=''): give the future that call_async() returns
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('asker')
rclpy.spin_until_future_complete(node, Trigger.Response())  # <-- here
