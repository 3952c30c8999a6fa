# The action's Result is published as feedback.
# says: Error raised in execute callback: expected example_interfaces.action.Fibonacci.Feedback, got example_interfaces.action.Fibonacci.Result: write Fibonacci.Feedback(…)
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer


def execute(goal_handle):
    goal_handle.publish_feedback(Fibonacci.Result(sequence=[0]))  # <-- here


rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(node, Fibonacci, 'fibonacci', execute)
client = ActionClient(node, Fibonacci, 'fibonacci')
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent)
rclpy.spin_until_future_complete(node, sent.result().get_result_async())
