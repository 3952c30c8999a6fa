"""tf2_py.BufferCore: stores transforms, given as messages, in a tree of frames."""

from __future__ import annotations

from typing import Protocol, TypeAlias

from builtin_interfaces.msg import Time as TimeMessage
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.logging import get_logger
from rclpy.time import Time
from std_msgs.msg import Header

from goalwire.errors import RejectedTransform, TransformException, peer_text
from goalwire.transforms.history import seconds
from goalwire.transforms.rigid import Rigid, Vector
from goalwire.transforms.tree import Found, FrameReport, TransformTree, Velocity

__all__ = ['BufferCore']

DEFAULT_CACHE_TIME = Duration(seconds=10)
_SHORTEST_HISTORY = 100_000  # ns; as in tf2, so that the rate of a single transform is defined


class _Stamp(Protocol):
    sec: int
    nanosec: int


Instant: TypeAlias = Time | _Stamp
"""A time of rclpy or of a message; 0 asks for the latest."""


class BufferCore:
    """A buffer of frames and the transforms between them, for the last `cache_time`."""

    def __init__(self, cache_time: Duration | None = None) -> None:
        self._tree = TransformTree((DEFAULT_CACHE_TIME if cache_time is None else cache_time).nanoseconds)

    def set_transform(self, transform: TransformStamped, authority: str) -> None:
        """Store a transform for the time of its stamp. Log and ignore an invalid transform."""
        self._insert(transform, authority, static=False)

    def set_transform_static(self, transform: TransformStamped, authority: str) -> None:
        """Store a transform for all times. Log and ignore an invalid transform."""
        self._insert(transform, authority, static=True)

    def clear(self) -> None:
        """Forget all transforms, but not the frames' names."""
        self._tree.clear()

    def lookup_transform_core(self, target_frame: str, source_frame: str, time: Instant) -> TransformStamped:
        """Return the transform that takes coordinates of the source frame to the target frame.

        Raises LookupException, ConnectivityException, ExtrapolationException, InvalidArgumentException.
        """
        found = self._tree.lookup(target_frame, source_frame, _nanoseconds(time))
        return _to_message(found, target_frame, source_frame)

    def lookup_transform_full_core(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
    ) -> TransformStamped:
        """Do as lookup_transform_core, from one time to another; `fixed_frame` must not move meanwhile."""
        found = self._tree.lookup_full(
            target_frame, _nanoseconds(target_time), source_frame, _nanoseconds(source_time), fixed_frame
        )
        return _to_message(found, target_frame, source_frame)

    def can_transform_core(self, target_frame: str, source_frame: str, time: Instant) -> tuple[bool, str]:
        """Return whether lookup_transform_core would succeed, and if not, the reason."""
        try:
            self._tree.lookup(target_frame, source_frame, _nanoseconds(time), 'canTransform')
        except TransformException as error:
            return False, str(error)
        return True, ''

    def can_transform_full_core(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
    ) -> tuple[bool, str]:
        """Return whether lookup_transform_full_core would succeed, and if not, the reason."""
        times = _nanoseconds(target_time), _nanoseconds(source_time)
        try:
            self._tree.lookup_full(
                target_frame, times[0], source_frame, times[1], fixed_frame, 'canTransform'
            )
        except TransformException as error:
            return False, str(error)
        return True, ''

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Time:
        """Return the latest time at which all transforms between two frames are known; 0 if all are static.

        As in tf2, the result has the type of the system clock. Raises TransformExceptions as
        lookup_transform_core does.
        """
        time = self._tree.latest_common_time(target_frame, source_frame, 'get_latest_common_time')
        return Time(nanoseconds=time, clock_type=ClockType.SYSTEM_TIME)

    def lookupVelocityCore(
        self, tracking_frame: str, observation_frame: str, time: Instant, averaging_interval: Duration
    ) -> Velocity:
        """Return the velocity of a frame as seen from another: linear in m/s, angular in rad/s.

        Both velocities are averages over an interval around `time` (0: an interval up to the latest time), in
        the observing frame's axes. Raises TransformExceptions as lookup_transform_core does, ValueError if
        the interval is not above 0.
        """
        at, span = _nanoseconds(time), averaging_interval.nanoseconds
        return self._tree.velocity(tracking_frame, observation_frame, at, span)

    def lookupVelocityFullCore(
        self,
        tracking_frame: str,
        observation_frame: str,
        reference_frame: str,
        reference_point: Vector,
        reference_point_frame: str,
        time: Instant,
        averaging_interval: Duration,
    ) -> Velocity:
        """Do as lookupVelocityCore, but for a point that moves with the tracked frame.

        The result is in the reference frame's axes. Raises as lookupVelocityCore does.
        """
        at, span = _nanoseconds(time), averaging_interval.nanoseconds
        point = reference_point, reference_point_frame
        return self._tree.velocity(tracking_frame, observation_frame, at, span, point, reference_frame)

    def all_frames_as_yaml(self) -> str:
        """Return a YAML mapping: parent, broadcaster, rate and times of every frame."""
        return ''.join(map(_yaml, self._tree.frames())) or '[]'

    def all_frames_as_string(self) -> str:
        """Return a text with a line for every frame, which names the frame's parent."""
        return ''.join(
            f'Frame {frame.name} exists with parent {frame.parent}.\n' for frame in self._tree.frames()
        )

    def _frameExists(self, frame_id: str) -> bool:
        return frame_id in self._tree.names()

    def _getFrameStrings(self) -> list[str]:
        return self._tree.names()

    def _insert(self, message: TransformStamped, authority: str, *, static: bool) -> None:
        header, transform = message.header, message.transform
        try:
            self._tree.insert(
                header.frame_id,
                message.child_frame_id,
                _nanoseconds(header.stamp),
                to_rigid(transform.translation, transform.rotation),
                authority=authority,
                static=static,
            )
        except RejectedTransform as error:
            get_logger('tf2_buffer').error(peer_text(error))


def to_rigid(translation: Vector3, rotation: Quaternion) -> Rigid:
    """Return the rigid transform with the translation and rotation in a message."""
    return Rigid(
        (translation.x, translation.y, translation.z), (rotation.x, rotation.y, rotation.z, rotation.w)
    )


def _nanoseconds(time: Instant) -> int:
    if isinstance(time, Time):
        return time.nanoseconds
    if hasattr(time, 'sec') and hasattr(time, 'nanosec'):
        return time.sec * 1_000_000_000 + time.nanosec
    raise TypeError(f'time must have sec and nanosec, or nanoseconds, not be {time!r}.')


def _to_message(found: Found, target: str, source: str) -> TransformStamped:
    (x, y, z), (qx, qy, qz, qw) = found.motion
    sec, nanosec = divmod(found.time, 1_000_000_000)
    return TransformStamped(
        header=Header(stamp=TimeMessage(sec=sec, nanosec=nanosec), frame_id=target),
        child_frame_id=source,
        transform=Transform(translation=Vector3(x=x, y=y, z=z), rotation=Quaternion(x=qx, y=qy, z=qz, w=qw)),
    )


def _yaml(frame: FrameReport) -> str:
    length = frame.newest - frame.oldest
    rate = frame.number * 1e9 / max(length, _SHORTEST_HISTORY)
    return (
        f'{frame.name}: \n'
        f"  parent: '{frame.parent}'\n"
        f"  broadcaster: '{frame.authority}'\n"
        f'  rate: {rate:.3f}\n'
        f'  most_recent_transform: {seconds(frame.newest)}\n'
        f'  oldest_transform: {seconds(frame.oldest)}\n'
        f'  buffer_length: {length / 1e9:.3f}\n'
    )
