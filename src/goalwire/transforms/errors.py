"""Why a transform cannot be told, as tf2 names it.

TransformException
├── ConnectivityException    the two frames are in two trees
├── ExtrapolationException   one link has no data for that time
├── InvalidArgumentException a frame name that cannot be
├── LookupException          a frame that nobody has spoken of, or a loop
└── TimeoutException         it did not come in time
"""

from goalwire.errors import LocalError


class TransformException(LocalError):
    """A transform cannot be told."""


class ConnectivityException(TransformException):
    """No path leads from one frame to the other."""


class ExtrapolationException(TransformException):
    """A link on the path has no data for the time asked for."""


class InvalidArgumentException(TransformException):
    """A frame name is empty or begins with a slash."""


class LookupException(TransformException):
    """A frame is unknown, or the links form a loop."""


class TimeoutException(TransformException):
    """The transform did not become known in time."""


class RejectedTransform(TransformException, ValueError):
    """A link that cannot be stored; the text begins with tf2's name of the reason."""
