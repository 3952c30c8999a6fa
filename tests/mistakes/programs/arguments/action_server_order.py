# The node is forgotten in ActionServer().
# says: the first argument of ActionServer is the node, got Fibonacci: write ActionServer(node, Fibonacci, 'fibonacci', execute)
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer

rclpy.init()
node = rclpy.create_node('counter')
ActionServer(Fibonacci, 'fib', lambda goal: Fibonacci.Result())  # <-- here
