"""Errors of coordinate frames, as tf2 has them."""

from __future__ import annotations

from goalwire.errors.base import LocalError


class TransformException(LocalError):
    """A transform cannot be computed or stored."""


class ConnectivityException(TransformException):
    """No path leads from one frame to the other."""


class ExtrapolationException(TransformException):
    """A link on the path has no data for the time asked for."""


class InvalidArgumentException(TransformException):
    """A frame name is empty or begins with a slash."""


class LookupException(TransformException):
    """A frame is unknown, or the links form a loop."""


class TransformTimeoutException(TransformException):
    """The transform did not become available in time (tf2_ros.TimeoutException)."""


# In tf2 it is called TimeoutException, which is also the name of an exception of rclpy.executors.
TransformTimeoutException.__name__ = TransformTimeoutException.__qualname__ = 'TimeoutException'
TransformTimeoutException.__module__ = 'tf2_py'


class RejectedTransform(TransformException, ValueError):
    """A transform cannot be stored in the tree; the text begins with tf2's name of the reason."""


class TypeException(LocalError):
    """tf2_ros was given an object of a type for which no transformation is registered."""

    def __init__(self, errstr: str) -> None:
        super().__init__(errstr)
        self.errstr = errstr


class NotImplementedException(LocalError, NotImplementedError):
    """A subclass of BufferInterface lacks a method."""

    def __init__(self) -> None:
        self.errstr = 'CanTransform or LookupTransform not implemented'
        super().__init__(self.errstr)
