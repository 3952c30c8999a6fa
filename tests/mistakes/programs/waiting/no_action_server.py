# The action client waits for a server that is not there.
# says: still waiting for action '/fib' after 5 s, no server is in domain
# within: 6 s
# ctrl-c: yes
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient

rclpy.init()
node = rclpy.create_node('asker')
client = ActionClient(node, Fibonacci, 'fib')
client.wait_for_server()  # <-- here
