# The result of a goal is asked for that was refused.
# says: the server refused this goal, so it has no result: write 'if goal_handle.accepted:' before you ask for the result
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer, GoalResponse

rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(
    node, Fibonacci, 'fibonacci', lambda goal: Fibonacci.Result(), goal_callback=lambda goal: GoalResponse.REJECT
)
client = ActionClient(node, Fibonacci, 'fibonacci')
client.wait_for_server()
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent)
handle = sent.result()
result = handle.get_result_async()  # <-- here
rclpy.spin_until_future_complete(node, result)
print(result.result().result.sequence)
