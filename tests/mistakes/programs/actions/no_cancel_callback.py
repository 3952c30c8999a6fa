# A goal is cancelled, and the server has no cancel callback.
# says: action 'fibonacci': a client asked to cancel a goal, and was refused, since the server has no cancel callback: to allow it, write ActionServer(…, cancel_callback=…) with a function that returns CancelResponse.ACCEPT
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


rclpy.init()
node = rclpy.create_node('counter')
group = ReentrantCallbackGroup()
server = ActionServer(node, Fibonacci, 'fibonacci', execute, callback_group=group)  # <-- here
client = ActionClient(node, Fibonacci, 'fibonacci')
executor = MultiThreadedExecutor()
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent, executor)
rclpy.spin_until_future_complete(node, sent.result().cancel_goal_async(), executor)
ended.set()
