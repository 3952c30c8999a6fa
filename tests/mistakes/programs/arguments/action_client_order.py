# The name stands before the type of an action client.
# says: a class of a message, a service or an action is needed: 'fib' is a text: write the class first and then the name, as in (CLASS, 'fib', …)
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient

rclpy.init()
node = rclpy.create_node('counter')
ActionClient(node, 'fib', Fibonacci)  # <-- here
