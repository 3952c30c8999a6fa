"""A picture from `publish()` to another process's callback, by size: python -m benchmarks.shared_memory.

Columns: over a socket; through shared memory, in an unmodified program; with a loan and a view. Beside them
stand those of `benchmarks.shared_memory_peers` whose packages are installed. Medians in µs, of rounds in
turn. `CLOCK_MONOTONIC` is one for all processes of a machine.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from array import array
from collections import defaultdict
from statistics import median

from helpers.isolation import free_port

from benchmarks import shared_memory_peers

SIZES = (64, 4096, 16384, 65536, 262_144, 1_000_000, 4_000_000, 16_000_000, 64_000_000)
WAYS = {'socket': 'off', 'memory': 'on', 'loan and view': 'on'}
POOL = 512 << 20
ROUNDS = 3


def count_of(size: int) -> int:
    """Return how many messages of a size are measured."""
    return 200 if size < 2_000_000 else 20


def echo(way: str) -> None:
    """Tell when each picture came."""
    import rclpy
    from sensor_msgs.msg import Image
    from std_msgs.msg import UInt64

    rclpy.init()
    node = rclpy.create_node('echo')
    publisher = node.create_publisher(UInt64, 'came', 10)

    def tell(_image: Image) -> None:
        publisher.publish(UInt64(data=time.perf_counter_ns()))

    node.create_subscription(Image, 'pictures', tell, 10, views=way == 'loan and view')
    rclpy.spin(node)


def measure(way: str) -> None:
    """Print for each size the median of the time from `publish()` to the callback, in µs."""
    import rclpy
    from sensor_msgs.msg import Image
    from std_msgs.msg import UInt64

    rclpy.init()
    node = rclpy.create_node('camera')
    publisher = node.create_publisher(Image, 'pictures', 10)
    came: list[int] = []
    node.create_subscription(UInt64, 'came', lambda message: came.append(message.data), 10)
    with subprocess.Popen([sys.executable, '-m', 'benchmarks.shared_memory', 'echo', way]) as other:
        while not (publisher.get_subscription_count() and node.count_publishers('came')):
            rclpy.spin_once(node, timeout_sec=0.05)
        for size in SIZES:
            image = Image(data=array('B', bytes(size)))
            times = []
            for _ in range(count_of(size)):
                came.clear()
                if way == 'loan and view':
                    loan = publisher.borrow_loaned_message(data=size)
                    began = time.perf_counter_ns()
                    publisher.publish(loan)
                else:
                    began = time.perf_counter_ns()
                    publisher.publish(image)
                while not came:
                    rclpy.spin_once(node, timeout_sec=1)
                times.append((came[0] - began) / 1000)
            print(size, median(times[len(times) // 4 :]), flush=True)
        other.kill()
    rclpy.shutdown()


def main() -> None:
    """Run each way in turn, and print a table."""
    found: defaultdict[tuple[int, str], list[float]] = defaultdict(list)
    ways = [*WAYS, *shared_memory_peers.installed()]
    for _ in range(ROUNDS):
        for way in ways:
            choice = WAYS.get(way, 'off')
            env = os.environ | {'GOALWIRE_SHARED_MEMORY': choice, 'ZENOH_SHM_ALLOC_SIZE': str(POOL)}
            command = [sys.executable, '-m', 'benchmarks.shared_memory', 'measure', way]
            text = subprocess.run(command, env=env, check=True, capture_output=True, text=True).stdout
            for line in text.splitlines():
                size_text, time_text = line.split()
                found[int(size_text), way].append(float(time_text))
    print('| bytes |', ' | '.join(f'{way}, µs' for way in ways), '|')
    print('|---|' + '---|' * len(ways))
    for size in SIZES:
        print(f'| {size:,} |', ' | '.join(f'{median(found[size, way]):,.0f}' for way in ways), '|')


if __name__ == '__main__':
    _, *arguments = sys.argv
    if arguments[:1] == ['echo']:
        echo(arguments[1])
    elif arguments[:1] == ['measure'] and arguments[1] in WAYS:
        measure(arguments[1])
    elif arguments[:1] == ['measure']:
        shared_memory_peers.measure(arguments[1], free_port(), {size: count_of(size) for size in SIZES})
    else:
        main()
