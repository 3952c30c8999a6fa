# A thread cancels a goal, the server refuses, and the program throws the answer away.
# says: action '/fibonacci': the server refused to cancel the goal, so the goal goes on, and this line does not look at the answer
# ctrl-c: yes
import threading

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer, CancelResponse


async def execute(goal_handle):
    await rclpy.task.Future()
    return Fibonacci.Result()


def stop_it():
    handle = client.send_goal_async(Fibonacci.Goal(order=3))
    handle.add_done_callback(lambda future: threading.Thread(target=cancel, args=[future]).start())


def cancel(future):
    future.result().cancel_goal()  # <-- here


rclpy.init()
node = rclpy.create_node('counter')
server = ActionServer(
    node, Fibonacci, 'fibonacci', execute, cancel_callback=lambda handle: CancelResponse.REJECT
)
client = ActionClient(node, Fibonacci, 'fibonacci')
stop_it()
rclpy.spin(node)
