"""As smach_ros: a state that sends a goal, cancels it, learns its end by callbacks; and a service state."""

import threading

import rclpy
import rclpy.action
import rclpy.time
from example_interfaces.action import Fibonacci
from rclpy.action.client import GoalStatus
from rclpy.executors import MultiThreadedExecutor
from std_msgs.msg import String
from std_srvs.srv import Trigger


class ActionState:
    """Sends a goal and waits on a condition for what the callbacks tell."""

    def __init__(self, node):
        self.client = rclpy.action.ActionClient(node, Fibonacci, 'fib')
        self.started = node.get_clock().now()
        self.patience = rclpy.time.Duration(seconds=30.0)
        self.done = threading.Condition()
        self.handle = self.status = self.result = None
        self.fed, self.accepted = threading.Event(), threading.Event()

    def execute(self, order, *, preempt):
        assert self.client.wait_for_server(10.0)
        with self.done:
            sent = self.client.send_goal_async(
                Fibonacci.Goal(order=order), feedback_callback=lambda _: self.fed.set()
            )
            sent.add_done_callback(self.on_sent)
            if preempt:
                threading.Thread(target=self.preempt).start()
            assert self.done.wait_for(lambda: self.result is not None, 20)
        assert self.result == self.client._get_result(self.handle).result
        return self.status

    def preempt(self):
        assert self.fed.wait(10)
        assert self.accepted.wait(10)  # two threads run callbacks: this one's may come second
        assert len(self.client._cancel_goal(self.handle).goals_canceling) == 1

    def on_sent(self, future):
        self.handle = future.result()
        self.accepted.set()
        self.client._get_result_async(self.handle).add_done_callback(self.on_result)

    def on_result(self, future):
        with self.done:
            self.status, self.result = future.result().status, future.result().result
            self.done.notify()


class Server:
    def __init__(self, node):
        self.cancelled = threading.Event()
        rclpy.action.ActionServer(
            node, Fibonacci, 'fib', self.execute, cancel_callback=lambda _: rclpy.action.CancelResponse.ACCEPT
        )

    def execute(self, handle):
        while handle.request.order > 5 and not handle.is_cancel_requested:
            handle.publish_feedback(Fibonacci.Feedback(sequence=[1]))
            self.cancelled.wait(0.01)
        handle.canceled() if handle.is_cancel_requested else handle.succeed()
        return Fibonacci.Result(sequence=[handle.request.order])


def main():
    rclpy.init()
    node, robot = rclpy.create_node('machine'), rclpy.create_node('robot')
    Server(robot)
    robot.create_service(Trigger, 'ready', lambda request, response: Trigger.Response(success=True))
    executor = MultiThreadedExecutor(8)
    executor.add_node(node)
    executor.add_node(robot)
    thread = threading.Thread(target=executor.spin, daemon=True)  # a failed assert ends the program
    thread.start()

    names = {getattr(GoalStatus, name): name for name in dir(GoalStatus) if name.startswith('STATUS_')}
    state = ActionState(node)
    print(names[state.execute(3, preempt=False)], list(state.result.sequence))
    state = ActionState(node)
    print(names[state.execute(9, preempt=True)], list(state.result.sequence))
    print('late', node.get_clock().now() - state.started > state.patience)

    ready = node.create_client(Trigger, 'ready')
    assert ready.wait_for_service(10.0)
    print('service', ready.call(Trigger.Request()).success)

    heard = threading.Event()
    latched = rclpy.qos.QoSProfile(depth=1, durability=rclpy.qos.DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_publisher(String, '/machine/smach/container_structure', latched).publish(String(data='DONE'))
    robot.create_subscription(
        String, '/machine/smach/container_structure', lambda message: heard.set(), latched
    )
    print('introspected', heard.wait(10))
    executor.shutdown(wait_for_threads=True)
    thread.join()
    rclpy.shutdown()


main()
