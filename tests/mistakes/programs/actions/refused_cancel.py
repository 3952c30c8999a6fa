# A client cancels a goal, the server refuses, and nobody looks at the answer.
# says: action '/fibonacci': the server refused to cancel the goal, so the goal goes on, and this line does not look at the answer: give the ActionServer cancel_callback=… with a function that returns CancelResponse.ACCEPT, and write here 'if not answer.goals_canceling:', which is true if the server refused
# within: 4 s
# ctrl-c: yes
import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer, CancelResponse


async def execute(goal_handle):
    await started
    return Fibonacci.Result()


rclpy.init()
node = rclpy.create_node('counter')
started = rclpy.task.Future()
server = ActionServer(
    node, Fibonacci, 'fibonacci', execute, cancel_callback=lambda handle: CancelResponse.REJECT
)
client = ActionClient(node, Fibonacci, 'fibonacci')
sent = client.send_goal_async(Fibonacci.Goal(order=3))
rclpy.spin_until_future_complete(node, sent)
sent.result().cancel_goal_async()  # <-- here
rclpy.spin(node)
