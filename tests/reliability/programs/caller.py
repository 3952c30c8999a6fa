"""Publishes 'beat' and calls 'add' all the time; for each line that it reads, prints how that went since.

The line: calls, their median, 99th percentile and longest in ms, wrong answers, and messages that were lost.
"""

import sys
import threading
from time import perf_counter, sleep

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

PAUSE_S = 0.002
COMING_S = 10.0
LASTING = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Caller:
    def __init__(self) -> None:
        self.node = rclpy.create_node('caller')
        self.adding = self.node.create_client(AddTwoInts, 'add')
        self.hearing = self.node.create_client(Trigger, 'heard')
        self.beat = self.node.create_publisher(String, 'beat', LASTING)
        self.wanted = threading.Event()
        self.forget()

    def forget(self) -> None:
        self.times: list[float] = []
        self.wrong = 0
        self.sent: set[str] = set()

    def call(self, number: int) -> None:
        self.beat.publish(String(data=str(number)))
        self.sent.add(str(number))
        began = perf_counter()
        future = self.adding.call_async(AddTwoInts.Request(a=number, b=1))
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=30)
        self.times.append(perf_counter() - began)
        result = future.result() if future.done() else None
        self.wrong += result is None or result.sum != number + 1

    def report(self) -> None:
        end = perf_counter() + COMING_S
        while self.sent and perf_counter() < end:
            future = self.hearing.call_async(Trigger.Request())
            rclpy.spin_until_future_complete(self.node, future, timeout_sec=30)
            if future.done() and future.result() is not None:
                self.sent -= set(future.result().message.split())
        taken = sorted(self.times)
        last = len(taken) - 1
        shares = (0.5, 0.99, 1.0)
        shown = (taken[min(int(len(taken) * each), last)] * 1000 if taken else 0.0 for each in shares)
        times = ' '.join(f'{each:.1f}' for each in shown)
        print(f'figures {len(taken)} {times} {self.wrong} {len(self.sent)}')
        self.forget()


def main() -> None:
    with rclpy.init():
        caller = Caller()
        assert caller.adding.wait_for_service(60)

        def listen() -> None:
            for _ in sys.stdin:
                caller.wanted.set()

        threading.Thread(target=listen, daemon=True).start()
        print('ready')
        for number in range(1_000_000_000):
            caller.call(number)
            if caller.wanted.is_set():
                caller.wanted.clear()
                caller.report()
            sleep(PAUSE_S)


if __name__ == '__main__':
    main()
