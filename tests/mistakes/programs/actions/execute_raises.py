# The execute callback raises.
# says: Error raised in execute callback: list index out of range; so the goal is aborted: correct execute() in execute_raises.py:11
# not: did not say how the goal ended
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer


def execute(goal_handle):
    sequence = [0, 1]
    sequence.append(sequence[-1] + sequence[-3])  # <-- here


rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(node, Fibonacci, 'fibonacci', execute)
client = ActionClient(node, Fibonacci, 'fibonacci')
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent)
rclpy.spin_until_future_complete(node, sent.result().get_result_async())
