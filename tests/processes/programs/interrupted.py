"""One end of a conversation whose talker is interrupted again and again by a signal's handler that talks too.

Arguments: talker or listener, and how often the handler is to come at least. The talker publishes and calls
on its main thread; the handler publishes with the same publishers and with one of its own, and calls. The
listener says what of each of them has come.
"""

import signal
import sys
from collections.abc import Callable

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile
from rclpy.task import Future
from std_msgs.msg import String

KEEP_ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL)
LASTING = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TOPICS = {'shared': KEEP_ALL, 'lasting': LASTING, 'handlers': KEEP_ALL}
PERIOD_S = 0.0005
EACH = 20
"""The main thread calls once for so many messages, the handler too."""
role, number = sys.argv[1], int(sys.argv[2])


class Talker(Node):
    def __init__(self) -> None:
        super().__init__('talker')
        self.publishers_of = {name: self.create_publisher(String, name, qos) for name, qos in TOPICS.items()}
        self.client = self.create_client(AddTwoInts, 'check')
        self.said = 0
        self.is_talking = True
        self.answers: list[Future[AddTwoInts.Response]] = []

    def interrupt(self, *_: object) -> None:
        count, self.said = self.said, self.said + 1
        for publisher in self.publishers_of.values():
            publisher.publish(String(data=f'handler {count}'))
        if count % EACH == 0:
            self.answers.append(self.client.call_async(AddTwoInts.Request(a=count, b=1)))
        if self.is_talking:
            signal.setitimer(signal.ITIMER_REAL, PERIOD_S)  # now, so that no handler interrupts another

    def talk(self) -> None:
        self.client.wait_for_service()
        self.ask(0, 0)  # an answer shows that both know all of each other's endpoints
        signal.signal(signal.SIGALRM, self.interrupt)
        signal.setitimer(signal.ITIMER_REAL, PERIOD_S)
        count = 0
        while self.said < number:
            for name in ('shared', 'lasting'):
                self.publishers_of[name].publish(String(data=f'main {count}'))
            if count % EACH == 0:
                assert self.ask(count, 1) == count + 1
            count += 1
        self.is_talking = False
        signal.setitimer(signal.ITIMER_REAL, 0)
        for future in list(self.answers):
            rclpy.spin_until_future_complete(self, future)
            assert future.result() is not None
        self.ask(self.said, -count)
        print(f'{len(self.answers)} calls of the handler were answered')

    def ask(self, a: int, b: int) -> int:
        future = self.client.call_async(AddTwoInts.Request(a=a, b=b))
        rclpy.spin_until_future_complete(self, future)
        answer = future.result()
        assert answer is not None
        return answer.sum


class Listener(Node):
    def __init__(self) -> None:
        super().__init__('listener')
        self.heard: dict[str, list[str]] = {name: [] for name in TOPICS}
        self.said: dict[str, int] = {}
        self.over: Future[None] = Future()
        for name, qos in TOPICS.items():
            self.create_subscription(String, name, self.hearing(name), qos)
        self.create_service(AddTwoInts, 'check', self.check)

    def hearing(self, name: str) -> Callable[[String], None]:
        def hear(message: String) -> None:
            self.heard[name].append(message.data)
            self.look()

        return hear

    def check(self, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        if request.b < 0:
            self.said = {'main': -request.b, 'handler': request.a}
            self.look()
        response.sum = request.a + request.b
        return response

    def look(self) -> None:
        if self.said and not self.over.done():
            both = sum(self.said.values())
            expected = {'shared': both, 'lasting': both, 'handlers': self.said['handler']}
            if all(len(self.heard[name]) >= count for name, count in expected.items()):
                self.over.set_result(None)

    def tell(self) -> None:
        for name, heard in self.heard.items():
            for who, count in self.said.items():
                if who != 'main' or name != 'handlers':
                    numbers = [int(text.split()[1]) for text in heard if text.startswith(f'{who} ')]
                    verdict = (
                        'all in order' if numbers == list(range(count)) else f'{len(numbers)} of {count}'
                    )
                    print(f'{name} of {who}: {verdict}')


def main() -> None:
    with rclpy.init():
        if role == 'talker':
            Talker().talk()
        else:
            listener = Listener()
            print('ready')
            rclpy.spin_until_future_complete(listener, listener.over)
            listener.tell()


main()
