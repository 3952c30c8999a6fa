# The execute callback calls succeed() twice.
# says: the goal has ended already: call succeed(), abort() or canceled() once
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer


def execute(goal_handle):
    goal_handle.succeed()
    goal_handle.succeed()  # <-- here
    return Fibonacci.Result()


rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(node, Fibonacci, 'fibonacci', execute)
client = ActionClient(node, Fibonacci, 'fibonacci')
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent)
rclpy.spin_until_future_complete(node, sent.result().get_result_async())
