"""tf2_ros.BufferInterface: the common base of all sources of transforms."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from std_msgs.msg import Header
from tf2_py.buffer_core import Instant

from goalwire.errors import NotImplementedException, TypeException
from tf2_ros.registration import ConvertRegistration, TransformRegistration, convert

__all__ = [
    'BufferInterface',
    'ConvertRegistration',
    'NotImplementedException',
    'Stamped',
    'TransformRegistration',
    'TypeException',
    'convert',
]

NO_TIME = Duration()


class BufferInterface:
    """Transforms stamped objects, by transforms that a subclass looks up."""

    def __init__(self) -> None:
        self.registration = TransformRegistration()

    def transform(
        self,
        object_stamped: Any,
        target_frame: str,
        timeout: Duration = NO_TIME,
        new_type: type | None = None,
    ) -> Any:
        """Return a stamped object in another frame at the object's time, as a `new_type` if given.

        Raises TypeException for a type that is not registered, and as lookup_transform does.
        """
        do_transform = self.registration.get(type(object_stamped))
        header = object_stamped.header
        found = self.lookup_transform(target_frame, header.frame_id, header.stamp, timeout)
        result = do_transform(object_stamped, found)
        return result if new_type is None else convert(result, new_type)

    def transform_full(
        self,
        object_stamped: Any,
        target_frame: str,
        target_time: Instant,
        fixed_frame: str,
        timeout: Duration = NO_TIME,
        new_type: type | None = None,
    ) -> Any:
        """Return a stamped object in another frame at another time. `fixed_frame` must not move meanwhile."""
        do_transform = self.registration.get(type(object_stamped))
        header = object_stamped.header
        found = self.lookup_transform_full(
            target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout
        )
        result = do_transform(object_stamped, found)
        return result if new_type is None else convert(result, new_type)

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Instant, timeout: Duration = NO_TIME
    ) -> TransformStamped:
        """Return the transform from source to target at a time."""
        raise NotImplementedException

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
        timeout: Duration = NO_TIME,
    ) -> TransformStamped:
        """Return the transform from the source at one time to the target at another."""
        raise NotImplementedException

    def can_transform(
        self, target_frame: str, source_frame: str, time: Instant, timeout: Duration = NO_TIME
    ) -> bool | tuple[bool, str]:
        """Return whether lookup_transform would succeed."""
        raise NotImplementedException

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
        timeout: Duration = NO_TIME,
    ) -> bool | tuple[bool, str]:
        """Return whether lookup_transform_full would succeed."""
        raise NotImplementedException


def Stamped(obj: Any, stamp: Any, frame_id: str) -> Any:
    """Give an object a header with this stamp and frame, and return the object."""
    obj.header = Header(frame_id=frame_id, stamp=stamp)
    return obj
