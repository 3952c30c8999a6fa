# The execute callback does not call succeed().
# says: action 'fibonacci': the execute callback execute() returned and did not say how the goal ended, so it counts as aborted: call goal_handle.succeed() before 'return', or abort() or canceled()
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer


def execute(goal_handle):  # <-- here
    return Fibonacci.Result(sequence=[0, 1])


rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(node, Fibonacci, 'fibonacci', execute)
client = ActionClient(node, Fibonacci, 'fibonacci')
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent)
rclpy.spin_until_future_complete(node, sent.result().get_result_async())
