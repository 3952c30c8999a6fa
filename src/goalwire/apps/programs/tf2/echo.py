"""tf2_echo: the transform between two frames, printed again and again."""

from __future__ import annotations

import math
import sys
from argparse import ArgumentParser
from collections.abc import Sequence

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.time import Time
from rclpy.utilities import remove_ros_args
from tf2_ros import Buffer, TransformException, TransformListener
from tf_transformations import euler_from_quaternion, quaternion_matrix

from goalwire.apps.programs.running import spin


class Echo(Node):
    """Prints where `target` is in `source`, `rate` times a second."""

    def __init__(self, source: str, target: str, rate: float, precision: int) -> None:
        super().__init__('tf2_echo')
        self._source, self._target, self._precision = source, target, precision
        self._buffer = Buffer(node=self)
        self._listener = TransformListener(self._buffer, self)
        self._has_come = False
        self.create_timer(1.0 / rate, self._look)

    def _look(self) -> None:
        try:
            found = self._buffer.lookup_transform(self._source, self._target, Time())
        except TransformException as error:
            if self._has_come:
                now = self.get_clock().now().nanoseconds / 1e9
                print(f'Failure at {now}\nException thrown:{error}\nThe current list of frames is:')
                print(self._buffer.all_frames_as_string(), flush=True)
            else:
                self.get_logger().info(
                    f'Waiting for transform {self._source} ->  {self._target}: {error}',
                    throttle_duration_sec=1.0,
                )
            return
        self._has_come = True
        print('\n'.join(describe(found, self._precision)), flush=True)


def describe(found: TransformStamped, precision: int = 3) -> list[str]:
    """Return the lines that tf2_echo prints for a transform: metres, quaternion, rad, degrees, matrix."""
    moved, turned, stamp = found.transform.translation, found.transform.rotation, found.header.stamp
    quaternion = (turned.x, turned.y, turned.z, turned.w)
    angles = euler_from_quaternion(quaternion)
    matrix = quaternion_matrix(quaternion)
    place = (moved.x, moved.y, moved.z, 1.0)

    def show(numbers: Sequence[float]) -> str:
        return ', '.join(f'{number:.{precision}f}' for number in numbers)

    lines = [
        f'At time {stamp.sec}.{stamp.nanosec}',
        f'- Translation: [{show(place[:3])}]',
        f'- Rotation: in Quaternion (xyzw) [{show(quaternion)}]',
        f'- Rotation: in RPY (radian) [{show(angles)}]',
        f'- Rotation: in RPY (degree) [{show([math.degrees(angle) for angle in angles])}]',
        '- Matrix:',
    ]
    for row, last in zip(matrix, place, strict=True):
        numbers = [*(float(number) for number in row[:3]), last]
        lines.append(''.join(f' {number:{precision + 3}.{precision}f}' for number in numbers))
    return lines


def main(argv: Sequence[str] | None = None) -> int:
    """Run tf2_echo."""
    arguments = list(sys.argv if argv is None else argv)
    parser = ArgumentParser(
        'tf2_echo',
        description='Print the transform that takes data from the target frame to the source frame.',
    )
    parser.add_argument('source_frame')
    parser.add_argument('target_frame')
    parser.add_argument(
        'echo_rate', nargs='?', type=_positive, default=1.0, help='in Hz; 1 if it is not given'
    )
    parser.add_argument('-p', '--precision', type=int, default=3, help='digits after the point')
    words = parser.parse_args(remove_ros_args(arguments)[1:])
    return spin(
        lambda: Echo(words.source_frame, words.target_frame, words.echo_rate, words.precision), arguments
    )


def _positive(text: str) -> float:
    number = float(text)
    if not 0.0 < number < math.inf:
        raise ValueError(text)
    return number
