"""static_transform_publisher: one transform on /tf_static, for as long as the program runs."""

from __future__ import annotations

import math
import secrets
import sys
from argparse import ArgumentParser
from collections.abc import Sequence

from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.utilities import remove_ros_args
from tf2_ros import StaticTransformBroadcaster
from tf_transformations import quaternion_from_euler

from goalwire.apps.programs.running import UsageError, declare_number, declare_text, spin

NAME = 'static_transform_publisher'
TRANSLATION = ('x', 'y', 'z')
EULER = ('roll', 'pitch', 'yaw')
QUATERNION = ('qx', 'qy', 'qz', 'qw')
SHORTEST = 1e-6


class StaticTransformPublisher(Node):
    """Publishes one transform.

    Parameters: `translation.x`, `.y`, `.z` in m, `rotation.x`, `.y`, `.z`, `.w`, `frame_id` and
    `child_frame_id`; their defaults come from `given`.
    """

    def __init__(self, given: TransformStamped, name: str) -> None:
        super().__init__(name)
        message = TransformStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = declare_text(self, 'frame_id', given.header.frame_id)
        message.child_frame_id = declare_text(self, 'child_frame_id', given.child_frame_id)
        for kind, parts in (('translation', 'xyz'), ('rotation', 'xyzw')):
            target, source = getattr(message.transform, kind), getattr(given.transform, kind)
            for part in parts:
                setattr(target, part, declare_number(self, f'{kind}.{part}', getattr(source, part)))
        self._broadcaster = StaticTransformBroadcaster(self)
        self._broadcaster.sendTransform(message)
        moved, turned = message.transform.translation, message.transform.rotation
        self.get_logger().info(
            'Spinning until stopped - publishing transform\n'
            f"translation: ('{moved.x:.6f}', '{moved.y:.6f}', '{moved.z:.6f}')\n"
            f"rotation: ('{turned.x:.6f}', '{turned.y:.6f}', '{turned.z:.6f}', '{turned.w:.6f}')\n"
            f"from '{message.header.frame_id}' to '{message.child_frame_id}'"
        )


def main(argv: Sequence[str] | None = None) -> int:
    """Publish the transform of the arguments; return the exit code."""
    arguments = list(sys.argv if argv is None else argv)
    words = remove_ros_args(arguments)[1:]
    parser = _make_parser()
    if words in (['-h'], ['--help']):
        parser.print_help()
        return 0
    try:
        given = read_arguments(words)
    except UsageError as error:
        get_logger(NAME).error(f'error parsing command line arguments: {error}')
        parser.print_usage(sys.stderr)
        return 1
    # Robots run several of these nodes at once, so each has a name of its own, as in ROS 2.
    name = f'{NAME}_{secrets.token_urlsafe(12).replace("-", "_")}'
    return spin(lambda: StaticTransformPublisher(given, name), arguments)


def read_arguments(words: list[str]) -> TransformStamped:
    """Return the transform of arguments in the new or the old style. Raises UsageError.

    The old style is `x y z yaw pitch roll frame child` or `x y z qx qy qz qw frame child`.
    """
    known, rest = _make_parser().parse_known_args(words)
    flags = {name: value for name, value in vars(known).items() if value is not None}
    if len(rest) in {8, 9}:
        if flags:
            raise UsageError('flags and arguments of the old style cannot be given together')
        get_logger(NAME).warning('Old-style arguments are deprecated; see --help for new-style arguments')
        turn = QUATERNION if len(rest) == 9 else tuple(reversed(EULER))
        flags = dict(zip((*TRANSLATION, *turn, 'frame_id', 'child_frame_id'), rest, strict=True))
    elif rest:
        raise UsageError(f"'{rest[0]}' is not understood")
    numbers = {
        name: _number(name, flags[name]) for name in (*TRANSLATION, *EULER, *QUATERNION) if name in flags
    }
    for frame in ('frame_id', 'child_frame_id'):
        if not flags.get(frame):
            raise UsageError(f'--{frame.replace("_", "-")} must be given')
    found = TransformStamped(child_frame_id=flags['child_frame_id'])
    found.header.frame_id = flags['frame_id']
    x, y, z = (numbers.get(name, 0.0) for name in TRANSLATION)
    found.transform = Transform(translation=Vector3(x=x, y=y, z=z), rotation=_rotation(numbers))
    return found


def _rotation(numbers: dict[str, float]) -> Quaternion:
    if numbers.keys() & set(EULER):
        if numbers.keys() & set(QUATERNION):
            raise UsageError('a quaternion and angles cannot be given together')
        roll, pitch, yaw = (numbers.get(name, 0.0) for name in EULER)
        x, y, z, w = (float(part) for part in quaternion_from_euler(roll, pitch, yaw))
    else:
        x, y, z, w = (numbers.get(name, 1.0 if name == 'qw' else 0.0) for name in QUATERNION)
    if math.hypot(x, y, z, w) < SHORTEST:
        raise UsageError('a quaternion of length 0 is not a rotation')
    return Quaternion(x=x, y=y, z=z, w=w)


def _number(name: str, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UsageError(f"{name} is '{text}': it must be a number")
    return number


def _make_parser() -> ArgumentParser:
    parser = ArgumentParser(
        NAME,
        description='Publish one transform. Without a translation or a rotation it is the identity.',
        add_help=False,
        allow_abbrev=False,
    )
    for name in TRANSLATION:
        parser.add_argument(f'--{name}', help=f'{name} of the translation, in m')
    for name in QUATERNION:
        parser.add_argument(f'--{name}', help=f'{name[1]} of the rotation as a quaternion')
    for name in EULER:
        parser.add_argument(f'--{name}', help=f'{name} of the rotation, in rad')
    parser.add_argument('--frame-id', help='the parent frame (required)')
    parser.add_argument('--child-frame-id', help='the child frame (required)')
    return parser
