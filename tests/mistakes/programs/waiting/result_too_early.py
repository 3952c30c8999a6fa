# The answer is read before it has come.
# says: 'NoneType' object has no attribute 'success' the answer that 'future' stands for has not come yet, so future.result() is None: write rclpy.spin_until_future_complete(node, future) before, or in an 'async def' await future
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('asker')
node.create_service(Trigger, 'battery', lambda request, response: response)
client = node.create_client(Trigger, 'battery')
future = client.call_async(Trigger.Request())
answer = future.result()
print(answer.success)  # <-- here
