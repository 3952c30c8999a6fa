# The program ends before the answer comes.
# says: the program ended before the answer of the service '/battery' came: write executor = SingleThreadedExecutor(), executor.add_node(…) for each node, and behind the call executor.spin_until_future_complete(future)
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
server = rclpy.create_node('power')
server.create_service(Trigger, 'battery', lambda request, response: response)
node = rclpy.create_node('asker')
client = node.create_client(Trigger, 'battery')
client.wait_for_service()
client.call_async(Trigger.Request())  # <-- here
rclpy.shutdown()
