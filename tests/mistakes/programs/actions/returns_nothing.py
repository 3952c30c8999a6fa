# The execute callback returns nothing.
# says: Action 'fibonacci': the execute callback returned NoneType; an empty result is sent; write 'return Fibonacci.Result(…)'
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer


def execute(goal_handle):  # <-- here
    goal_handle.succeed()


rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(node, Fibonacci, 'fibonacci', execute)
client = ActionClient(node, Fibonacci, 'fibonacci')
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent)
rclpy.spin_until_future_complete(node, sent.result().get_result_async())
