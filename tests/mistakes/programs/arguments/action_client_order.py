# The name stands before the type of an action client.
# says: a class of a message, a service or an action is needed: 'fib' is a text: the class stands before the name: write ActionClient(node, Fibonacci, 'fib')
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient

rclpy.init()
node = rclpy.create_node('counter')
ActionClient(node, 'fib', Fibonacci)  # <-- here
