"""The cost of messages: making, encoding and decoding one, best of several runs, in microseconds.

python benchmarks/codec.py [TYPE…]
"""

from __future__ import annotations

import sys
import timeit
from collections.abc import Callable
from typing import Any

from goalwire.cdr import codec
from goalwire.idl import get_message

REPEATS = 7


def pose_stamped() -> Any:
    message: Any = get_message('geometry_msgs/msg/PoseStamped')()
    message.header.frame_id = 'base_link'
    message.pose.position.x = 1.5
    return message


def joint_state() -> Any:
    names = [f'joint_{number}' for number in range(7)]
    cls: Any = get_message('sensor_msgs/msg/JointState')
    return cls(name=names, position=[0.5] * 7, velocity=[0.0] * 7, effort=[0.0] * 7)


def imu() -> Any:
    return get_message('sensor_msgs/msg/Imu')()


def path() -> Any:
    cls: Any = get_message('nav_msgs/msg/Path')
    return cls(poses=[pose_stamped() for _ in range(100)])


def marker() -> Any:
    cls: Any = get_message('visualization_msgs/msg/Marker')
    point: Any = get_message('geometry_msgs/msg/Point')
    return cls(points=[point(x=float(number)) for number in range(1000)])


def image() -> Any:
    cls: Any = get_message('sensor_msgs/msg/Image')
    return cls(height=1080, width=1920, encoding='bgr8', step=5760, data=bytes(1080 * 5760))


CASES: dict[str, Callable[[], Any]] = {
    'String': lambda: get_message('std_msgs/msg/String')(data='hello'),
    'PoseStamped': pose_stamped,
    'JointState of 7': joint_state,
    'Imu': imu,
    'Path of 100 poses': path,
    'Marker of 1000 points': marker,
    'Image of 6 MB': image,
}


def best(action: Callable[[], object]) -> float:
    """Return the microseconds of one call."""
    timer = timeit.Timer(action)
    number, _ = timer.autorange()
    number = max(1, number // 4)
    return min(timer.repeat(REPEATS, number)) / number * 1e6


def main() -> None:
    print(f'{"":24}{"bytes":>9}{"new":>11}{"encode":>11}{"decode":>11}')
    for name, make in CASES.items():
        if len(sys.argv) > 1 and name.split()[0] not in sys.argv[1:]:
            continue
        message = make()
        cls: type = type(message)
        encode, decode = codec.encoder(cls), codec.decoder(cls)
        data = encode(message)
        costs = (best(cls), best(lambda: encode(message)), best(lambda: decode(data)))  # noqa: B023
        print(f'{name:24}{len(data):9}' + ''.join(f'{cost:11.2f}' for cost in costs))


if __name__ == '__main__':
    main()
