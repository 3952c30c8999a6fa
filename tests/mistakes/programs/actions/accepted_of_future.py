# The future of send_goal_async() is taken for the goal's handle.
# says: 'GoalCall' object has no attribute 'accepted': this is a future, whose result comes later; wait for it, by rclpy.spin_until_future_complete(node, future) or 'await', and then write future.result().accepted
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer

rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(node, Fibonacci, 'fibonacci', lambda goal: Fibonacci.Result())
client = ActionClient(node, Fibonacci, 'fibonacci')
handle = client.send_goal_async(Fibonacci.Goal(order=3))
if handle.accepted:  # <-- here
    print('accepted')
