"""Every error goalwire raises, in one tree.

GoalwireError
├── LocalError            the caller's mistake: fix the program
│   ├── ClosedError       the context, node or endpoint is no longer open
│   │   └── InvalidHandle  the same, as rclpy's programs catch it
│   └── ForkedError       a context opened before fork() is used in the child
├── RemoteError           a peer sent something that breaks the rules
├── TransportError        the wire itself failed: no session, refused configuration
├── NoServerError         nobody serves that name
├── ServerLostError       the server went away before it answered
└── DeadlineError         the answer did not come in time (also a TimeoutError)
"""


class GoalwireError(Exception):
    """The root: catches whatever goalwire raises."""


class LocalError(GoalwireError):
    """The caller's mistake."""


class ClosedError(LocalError):
    """A context, node or endpoint was used after it was closed."""


class InvalidHandle(ClosedError):
    """A destroyed entity was used (rclpy.exceptions.InvalidHandle)."""

    def __init__(self, message: str = 'cannot use Destroyable because destruction was requested') -> None:
        super().__init__(message)


class ForkedError(LocalError):
    """A context opened before fork() was used in the child process."""


class RemoteError(GoalwireError):
    """A peer sent something that breaks the rules."""


class TransportError(GoalwireError):
    """The wire itself failed."""


class NoServerError(GoalwireError):
    """Nobody serves that name."""


class ServerLostError(GoalwireError):
    """The server went away before it answered."""


class DeadlineError(GoalwireError, TimeoutError):
    """The answer did not come in time."""
