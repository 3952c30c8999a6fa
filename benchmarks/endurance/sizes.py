"""One large reliable message, and the same once more: how long until it has come whole, and the memory."""

from __future__ import annotations

import os
import sys
import zlib
from time import sleep

from benchmarks import stage
from benchmarks.endurance.held import peak_mib
from benchmarks.line import Figures

PATIENCE_S = 300.0
TIMES = 2


def content(size: int) -> bytes:
    """Return bytes that are not all alike."""
    piece = bytes(range(256)) * 4096
    return (piece * (size // len(piece) + 1))[:size]


def answer() -> None:
    import rclpy
    from std_msgs.msg import UInt8MultiArray, UInt64MultiArray

    rclpy.init()
    node = rclpy.create_node('endurance_reader')
    acknowledgement = node.create_publisher(UInt64MultiArray, 'endurance_came', 10)

    def on_message(message: UInt8MultiArray) -> None:
        data = memoryview(message.data)
        acknowledgement.publish(UInt64MultiArray(data=[len(data), zlib.crc32(data)]))

    node.create_subscription(UInt8MultiArray, 'endurance_large', on_message, 10)
    stage.serve(node)


def ask(size: int) -> Figures:
    import rclpy
    from std_msgs.msg import UInt8MultiArray, UInt64MultiArray

    came: list[list[int]] = []
    with stage.Partner('benchmarks.endurance.sizes') as reader:
        rclpy.init()
        node = rclpy.create_node('endurance_writer')
        node.create_subscription(
            UInt64MultiArray, 'endurance_came', lambda message: came.append(list(message.data)), 10
        )
        publisher = node.create_publisher(UInt8MultiArray, 'endurance_large', 10)
        while not (publisher.get_subscription_count() and node.count_publishers('endurance_came')):
            sleep(0.01)
        message = UInt8MultiArray(data=content(size))
        expected = [size, zlib.crc32(memoryview(message.data))]
        figures: Figures = {}
        for which in range(1, TIMES + 1):
            came.clear()
            watch = stage.Stopwatch()
            publisher.publish(message)
            while not came:
                rclpy.spin_once(node, timeout_sec=PATIENCE_S)
                if watch.read() > PATIENCE_S:
                    sys.exit(f'a message of {size} bytes did not come within {PATIENCE_S:.0f} s')
            figures[f's, {which}.'] = watch.read()
            assert came == [expected]
        figures |= {'writer MiB at most': peak_mib(os.getpid()), 'reader MiB at most': peak_mib(reader.pid)}
        rclpy.shutdown()
        return figures


if __name__ == '__main__':
    stage.run(ask, answer)
