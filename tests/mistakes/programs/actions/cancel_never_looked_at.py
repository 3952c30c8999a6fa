# The execute callback never looks at is_cancel_requested.
# says: action 'fibonacci': the goal was cancelled, and the execute callback execute() does not look at that: write 'if goal_handle.is_cancel_requested:' in its loop, and there call goal_handle.canceled() and return
# within: 5 s
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from threading import Event

canceled = Event()


def execute(goal_handle):  # <-- here
    canceled.wait(8)
    goal_handle.succeed()
    return Fibonacci.Result()


rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(
    node,
    Fibonacci,
    'fibonacci',
    execute,
    cancel_callback=lambda goal: CancelResponse.ACCEPT,
    callback_group=ReentrantCallbackGroup(),
)
client = ActionClient(node, Fibonacci, 'fibonacci')
executor = MultiThreadedExecutor()
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent, executor)
result = sent.result().get_result_async()
rclpy.spin_until_future_complete(node, sent.result().cancel_goal_async(), executor)
canceled.set()
rclpy.spin_until_future_complete(node, result, executor)
