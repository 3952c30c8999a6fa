# The goal callback returns True.
# says: action 'fibonacci': the goal callback check() returned True, so the goal is refused: return GoalResponse.ACCEPT or GoalResponse.REJECT
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer


def check(goal):  # <-- here
    return True


rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(node, Fibonacci, 'fibonacci', lambda goal: Fibonacci.Result(), goal_callback=check)
client = ActionClient(node, Fibonacci, 'fibonacci')
rclpy.spin_until_future_complete(node, client.send_goal_async(Fibonacci.Goal(order=3)))
