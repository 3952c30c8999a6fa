# The cancel callback returns True.
# says: action 'fibonacci': the cancel callback cancel() returned True, so cancelling is refused: return CancelResponse.ACCEPT or CancelResponse.REJECT
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from threading import Event

ended = Event()


def execute(goal_handle):
    ended.wait(8)
    goal_handle.succeed()
    return Fibonacci.Result()


def cancel(goal_handle):  # <-- here
    return True


rclpy.init()
node = rclpy.create_node('counter')
group = ReentrantCallbackGroup()
server = ActionServer(node, Fibonacci, 'fibonacci', execute, cancel_callback=cancel, callback_group=group)
client = ActionClient(node, Fibonacci, 'fibonacci')
executor = MultiThreadedExecutor()
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent, executor)
rclpy.spin_until_future_complete(node, sent.result().cancel_goal_async(), executor)
ended.set()
