"""A program with an extension in C that keeps the interpreter's lock, and one that talks to it meanwhile.

Arguments: holder or talker, and for how many seconds. While the lock is held no thread of Python runs, that
which says that the program lives neither.
"""

import ctypes
import sys

import rclpy
from example_interfaces.msg import Int64
from example_interfaces.srv import AddTwoInts
from rclpy.event_handler import PublisherEventCallbacks, QoSPublisherMatchedInfo
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile
from rclpy.task import Future

KEEP_ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL)
COUNT = 500
role, seconds = sys.argv[1], int(sys.argv[2])


class Holder(Node):
    def __init__(self) -> None:
        super().__init__('holder')
        self.numbers: list[int] = []
        self.over: Future[None] = Future()
        self.create_subscription(Int64, 'numbers', self.hear, KEEP_ALL)
        self.create_service(AddTwoInts, 'hold', self.hold)

    def hold(self, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        print('holds')
        ctypes.PyDLL(None).sleep(request.a)  # a function of such a library is called with the lock held
        response.sum = request.a + request.b
        return response

    def hear(self, message: Int64) -> None:
        self.numbers.append(message.data)
        if message.data == COUNT - 1:
            self.over.set_result(None)


class Talker(Node):
    def __init__(self) -> None:
        super().__init__('talker')
        self.lost = 0
        watch = PublisherEventCallbacks(matched=self.on_matched)
        self.publisher = self.create_publisher(Int64, 'numbers', KEEP_ALL, event_callbacks=watch)
        self.client = self.create_client(AddTwoInts, 'hold')

    def on_matched(self, info: QoSPublisherMatchedInfo) -> None:
        self.lost += info.current_count_change < 0

    def ask(self, a: int) -> Future[AddTwoInts.Response]:
        return self.client.call_async(AddTwoInts.Request(a=a, b=1))


def talk() -> None:
    talker = Talker()
    talker.client.wait_for_service()
    rclpy.spin_until_future_complete(talker, talker.ask(0))  # then both know all of each other's endpoints
    answers = [talker.ask(seconds), talker.ask(0)]
    for number in range(COUNT):
        talker.publisher.publish(Int64(data=number))
    for future in answers:
        rclpy.spin_until_future_complete(talker, future)
    print(f'answers {[answer.sum for answer in (future.result() for future in answers) if answer]}')
    print(f'lost {talker.lost} times')


with rclpy.init():
    if role == 'talker':
        talk()
    else:
        holder = Holder()
        print('ready')
        rclpy.spin_until_future_complete(holder, holder.over)
        print(f'heard all in order: {holder.numbers == list(range(COUNT))}')
        input()  # its end would count as a loss
