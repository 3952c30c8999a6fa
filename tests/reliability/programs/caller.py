"""Calls 'add' all the time; for each line that it reads, prints how many there were since, and their times.

The line: calls, the median, the 99th percentile and the longest in ms, and how many wrong answers.
"""

import sys
import threading
from time import perf_counter, sleep

import rclpy
from example_interfaces.srv import AddTwoInts

PAUSE_S = 0.002


def report(times: list[float], wrong: list[int]) -> None:
    for _ in sys.stdin:
        taken = sorted(times)
        times.clear()
        last = len(taken) - 1
        middle, high, most = (
            taken[min(int(len(taken) * share), last)] * 1000 if taken else 0.0 for share in (0.5, 0.99, 1)
        )
        print(f'figures {len(taken)} {middle:.1f} {high:.1f} {most:.1f} {len(wrong)}')


def main() -> None:
    with rclpy.init():
        node = rclpy.create_node('caller')
        client = node.create_client(AddTwoInts, 'add')
        assert client.wait_for_service(60)
        times: list[float] = []
        wrong: list[int] = []
        threading.Thread(target=report, args=(times, wrong), daemon=True).start()
        print('ready')
        for number in range(1_000_000_000):
            began = perf_counter()
            future = client.call_async(AddTwoInts.Request(a=number, b=1))
            rclpy.spin_until_future_complete(node, future, timeout_sec=30)
            times.append(perf_counter() - began)
            result = future.result() if future.done() else None
            if result is None or result.sum != number + 1:
                wrong.append(number)
            sleep(PAUSE_S)


if __name__ == '__main__':
    main()
