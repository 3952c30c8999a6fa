"""Every error goalwire raises, in one tree.

GoalwireError
├── LocalError            the caller's mistake: fix the program
│   ├── NotInitializedException  rclpy.init() was not called
│   ├── ROSInterruptException    a sleep was ended by shutdown
│   ├── TimeSourceChangedError   … by a switch between system and simulated time
│   ├── ClosedError       the context, node or endpoint is no longer open
│   │   └── InvalidHandle  the same, as rclpy's programs catch it
│   │       └── DestroyedError   … and as AsyncNode's do (also a RuntimeError)
│   ├── ForkedError       a context opened before fork() is used in the child
│   ├── InterfaceError    a .msg, .srv or .action cannot be used (also an ImportError)
│   │   ├── InterfaceSyntaxError   its text breaks the grammar
│   │   └── UnknownInterfaceError  no such package or type
│   ├── EncodeError       a message's value does not fit its field
│   │   ├── EncodeTypeError        … by its type (also a TypeError)
│   │   └── EncodeValueError       … by its value (also a ValueError)
│   ├── UnknownFieldError a message has no such field (also an AssertionError and a TypeError)
│   ├── TooManyCallsError a client has too many calls that wait for their answers
│   └── WouldDeadlockError  a blocking call that waits for its own thread or group
├── RemoteError           a peer sent something that breaks the rules
│   └── DecodeError       bytes that are no message of the expected type (also a ValueError)
├── TransportError        the wire itself failed: no session, refused configuration
└── CallError             a call or goal that did not end well
    ├── NoServerError     nobody served that name in time (also a TimeoutError)
    ├── DeadlineError     the answer did not come in time (also a TimeoutError)
    ├── ServerLostError   the server went away before it answered
    ├── ServerStuckError  the goal's server gave no sign of life for too long
    ├── ServerFailedError the server gave the request up: its callback failed
    ├── RefusedError      the server did not take the request
    │   └── GoalRefused   the action server did not accept the goal
    └── GoalFailed        the goal ended without success
        ├── GoalAborted   … since it could not be reached
        └── GoalCanceled  … since it was cancelled
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

PEER_TEXT_LIMIT = 500
"""Characters of a text of a peer's that errors and logs show."""

_CONTROLS = (
    *range(0x20), *range(0x7F, 0xA0),  # C0, DEL, C1: line breaks, terminal escapes
    0x061C, 0x200E, 0x200F, *range(0x202A, 0x202F), *range(0x2066, 0x206A),  # what turns text around
    0x2028, 0x2029,  # further line breaks
)  # fmt: skip
_ESCAPED = {code: chr(code).encode('unicode_escape').decode() for code in _CONTROLS}


def peer_text(text: object, limit: int = PEER_TEXT_LIMIT) -> str:
    r"""Return what a peer wrote as one line of at most `limit` characters, for an error or a log.

    Control characters are spelt out (`\n`, `\x1b`): a peer can neither forge lines nor steer a terminal.
    What was through here once stays as it is.
    """
    told = str(text)[: limit + 1].translate(_ESCAPED)
    return told if len(told) <= limit else told[: limit - 1] + '…'


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


class DestroyedError(InvalidHandle, RuntimeError):
    """A destroyed entity was used, where newer parts of rclpy raise RuntimeError."""


class NotInitializedException(LocalError):
    """rclpy.init() has not been called (rclpy.exceptions)."""

    def __init__(self, message: str | None = None) -> None:
        text = 'rclpy.init() has not been called'
        super().__init__(f'{text}. msg:{message}' if message else f'{text}.')


class ROSInterruptException(LocalError):
    """A sleep was ended by shutdown (rclpy.exceptions)."""

    def __init__(self) -> None:
        super().__init__('rclpy.shutdown() has been called')


class TimeSourceChangedError(LocalError):
    """A sleep was ended by a switch between system and simulated time (rclpy.exceptions)."""

    def __init__(self) -> None:
        super().__init__(
            'simulated time was switched on or off during the sleep: how long is left is unknown'
        )


class ForkedError(LocalError):
    """A context opened before fork() was used in the child process."""


class InterfaceError(LocalError, ImportError):
    """A .msg, .srv or .action cannot be used."""


class InterfaceSyntaxError(InterfaceError):
    """A definition breaks the grammar; `line` and `column` count from 1, 0 where there is none."""

    def __init__(self, source: str, line: int, column: int, problem: str) -> None:
        super().__init__(f'{source}:{line}:{column}: {problem}')
        self.source = source
        self.line = line
        self.column = column
        self.problem = problem


class UnknownInterfaceError(InterfaceError):
    """No such interface package, or no such type in it."""


class EncodeError(LocalError):
    """A value does not fit its field; `field` is its path in the message of type `type_name`."""

    def __init__(self, type_name: str, field: str, problem: str) -> None:
        super().__init__(f'{type_name}: {field}: {problem}' if field else f'{type_name}: {problem}')
        self.type_name = type_name
        self.field = field


class EncodeTypeError(EncodeError, TypeError):
    """A value has the wrong type for its field."""


class EncodeValueError(EncodeError, ValueError):
    """A value has the right type, but the field cannot hold it."""


class UnknownFieldError(LocalError, AssertionError, TypeError):
    """A message's constructor got a keyword that names no field: rosidl asserts, Python raises TypeError."""


class WouldDeadlockError(LocalError, RuntimeError):
    """A blocking call whose answer needs the very thread or callback group that waits for it."""


class TooManyCallsError(LocalError, RuntimeError):
    """A client has so many calls under way that another one would be a leak."""


class RemoteError(GoalwireError):
    """A peer sent something that breaks the rules; what it quotes of that is `peer_text`."""

    def __init__(self, message: str = '') -> None:
        super().__init__(peer_text(message))


class DecodeError(RemoteError, ValueError):
    """Bytes that are no message of `type_name`; `offset` counts from the first byte, header included."""

    def __init__(self, type_name: str, field: str, offset: int, problem: str) -> None:
        where = f'{field}: ' if field else ''
        super().__init__(f'{type_name}: {where}at byte {offset}: {problem}')
        self.type_name = type_name
        self.field = field
        self.offset = offset


class TransportError(GoalwireError):
    """The wire itself failed."""


class CallError(GoalwireError):
    """A call or goal that did not end well."""

    def __init__(
        self, message: str = '', *, name: str = '', peers: Sequence[str] = (), waited: float = 0.0
    ) -> None:
        super().__init__(message)
        self.name = name
        """The fully-qualified name of the service or action."""
        self.peers = tuple(peers)
        """The nodes that served it when it was called."""
        self.waited = waited
        """How long the caller has waited, in s."""


class NoServerError(CallError, TimeoutError):
    """Nobody served that name in time."""


class DeadlineError(CallError, TimeoutError):
    """The answer did not come in time."""


class ServerLostError(CallError):
    """The server went away before it answered, or forgot the goal."""


class ServerStuckError(CallError):
    """The goal's server gave no sign of life for longer than the caller's heartbeat."""


class ServerFailedError(CallError):
    """The server gave the request up: its callback failed, or was stopped."""


class RefusedError(CallError):
    """The server did not take the request: it has too much to do, or cannot read it."""


class GoalRefused(RefusedError):
    """The action server did not accept the goal."""


class GoalFailed(CallError):
    """The goal ended without success."""

    def __init__(
        self,
        message: str = '',
        *,
        result: Any = None,
        name: str = '',
        peers: Sequence[str] = (),
        waited: float = 0.0,
    ) -> None:
        super().__init__(message, name=name, peers=peers, waited=waited)
        self.result = result
        """What the server sent along: a result of the action, of default values where it had none."""


class GoalAborted(GoalFailed):
    """The goal could not be reached; raised by an action server's handler, it ends the goal so."""


class GoalCanceled(GoalFailed):
    """The goal was cancelled."""
