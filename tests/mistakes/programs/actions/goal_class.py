# The action's class is sent and not a goal.
# says: Action classes can not be instantiated: Fibonacci only holds its parts; write Fibonacci.Goal()
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient

rclpy.init()
node = rclpy.create_node('counter')
client = ActionClient(node, Fibonacci, 'fibonacci')
client.send_goal_async(Fibonacci())  # <-- here
