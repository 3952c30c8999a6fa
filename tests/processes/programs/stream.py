"""One end of a stream of messages, of which none may be lost. Pauses after a tenth, a half and at the end.

Arguments: publisher or subscriber, and the number of messages. The subscriber asks for a batch at a time, so
that neither end has more than that in hand.
"""

import gc
import sys

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile
from rclpy.task import Future
from std_msgs.msg import UInt32MultiArray

BATCH = 500
KEEP_ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL)
"""On Zenoh a publisher that keeps less drops messages if the wire is full."""
role, number = sys.argv[1], int(sys.argv[2])


def pause(title: str) -> None:
    gc.collect()
    print(title)
    input()


def pause_at(count: int) -> None:
    if count == number // 10:
        pause('before')
    elif count == number // 2:
        pause('between')
    elif count == number:
        pause('after')


def publish(node: Node) -> None:
    publisher = node.create_publisher(UInt32MultiArray, 'stream', KEEP_ALL)
    over: Future[None] = Future()
    message = UInt32MultiArray(data=list(range(25)))

    def pour(request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        for _ in range(request.b):
            publisher.publish(message)
        pause_at(request.a + request.b)
        if request.a + request.b == number:
            over.set_result(None)
        return response

    node.create_service(AddTwoInts, 'pour', pour)
    rclpy.spin_until_future_complete(node, over)


def subscribe(node: Node) -> None:
    count = 0
    over: Future[None] = Future()

    def on_message(message: UInt32MultiArray) -> None:
        nonlocal count
        count += 1
        pause_at(count)
        if count == number:
            over.set_result(None)
        elif count % BATCH == 0:
            _ = ask(BATCH)

    def ask(batch: int) -> Future[AddTwoInts.Response]:
        return client.call_async(AddTwoInts.Request(a=count, b=batch))

    node.create_subscription(UInt32MultiArray, 'stream', on_message, KEEP_ALL)
    client = node.create_client(AddTwoInts, 'pour')
    client.wait_for_service()
    # An answer shows that both know all of each other's endpoints.
    rclpy.spin_until_future_complete(node, ask(0))
    _ = ask(BATCH)
    rclpy.spin_until_future_complete(node, over)


with rclpy.init():
    {'publisher': publish, 'subscriber': subscribe}[role](rclpy.create_node(role))
