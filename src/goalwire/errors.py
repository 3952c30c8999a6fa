"""Every error that goalwire raises, in one tree; the modules rclpy and tf2 re-export theirs from here.

GoalwireError
├── LocalError            the caller's mistake: fix the program
│   ├── NotInitializedException  rclpy.init() was not called
│   ├── ROSInterruptException    a sleep was ended by shutdown
│   ├── TimeSourceChangedError   … by a switch between system and simulated time
│   ├── ClosedError       the context, node or endpoint is no longer open
│   │   ├── InvalidHandle  the same, as rclpy's programs catch it
│   │   │   └── DestroyedError   … and as AsyncNode's do (also a RuntimeError)
│   │   ├── ShutdownException          an executor was shut down
│   │   └── ExternalShutdownException  a spin was ended by shutdown
│   ├── ForkedError       a context opened before fork() is used in the child
│   ├── RCLError          what rclpy's C library refuses (also a RuntimeError)
│   │   ├── ShutDownError             the context was shut down (also a ClosedError)
│   │   │   └── ShutDownBySignalError … by a signal (also an ExternalShutdownException)
│   │   ├── RCLInvalidROSArgsError    arguments of a node that do not parse
│   │   ├── UnknownROSArgsError       arguments that ROS 2 does not know
│   │   ├── UnsupportedEventTypeError an event that the wire cannot tell
│   │   └── NodeNameNonExistentError  a graph question about a node that is not there
│   ├── RMWError, RCUtilsError    never raised; programs catch them (also a RuntimeError)
│   ├── InterfaceError    a .msg, .srv or .action cannot be used (also an ImportError)
│   │   ├── InterfaceSyntaxError   its text breaks the grammar
│   │   └── UnknownInterfaceError  no such package or type
│   ├── NoTypeSupportImportedException  a class given as a message type is none
│   ├── EncodeError       a message's value does not fit its field
│   │   ├── EncodeTypeError        … by its type (also a TypeError)
│   │   └── EncodeValueError       … by its value (also a ValueError)
│   ├── UnknownFieldError a message has no such field (also an AssertionError and a TypeError)
│   ├── TopicExpansionError       no full name can be made of a name (also a ValueError)
│   ├── NameValidationException   a name that ROS 2 forbids
│   │   └── InvalidNodeNameException, InvalidNamespaceException, InvalidTopicNameException,
│   │       InvalidServiceNameException
│   ├── ParameterException        a parameter may not be used like that
│   │   └── ParameterNotDeclaredException, ParameterAlreadyDeclaredException,
│   │       InvalidParameterException (its name), InvalidParameterTypeException,
│   │       InvalidParameterValueException, ParameterImmutableException, ParameterUninitializedException
│   ├── CallbackError     a callback before a set returned no list of parameters (also a TypeError)
│   ├── UnknownCallbackError  a callback was removed twice (also a RuntimeError)
│   ├── FileShapeError    YAML that is not a parameter file (also a RuntimeError)
│   ├── InvalidQoSProfileException, UnknownPolicyError, UnexpectedOverrideError, InvalidQosOverridesError
│   │                     a QoS profile, or what parameters make of it, cannot be
│   ├── InvalidTransition a goal's state does not allow that event (also a RuntimeError)
│   ├── GoalIdTaken       a goal is sent under the id of another (also a ValueError)
│   ├── UnknownSeverityError, LoggingOptionError, LoggerNameError, ChangedCallError
│   │                     a logger was not used as it can be
│   ├── TransformException        a transform cannot be told (tf2_ros)
│   │   └── ConnectivityException, ExtrapolationException, InvalidArgumentException, LookupException,
│   │       TimeoutException (here TransformTimeoutException), RejectedTransform
│   ├── TypeException, NotImplementedException   tf2_ros was given an object that it cannot transform
│   ├── LaunchError       a launch file asks for what cannot be done (also a RuntimeError)
│   │   ├── InvalidLaunchFileError    it cannot be read
│   │   │   └── InvalidFrontendLaunchFileError   … as XML or YAML
│   │   └── SubstitutionFailure, InvalidConditionExpressionError, NoSuchPackageError, NoLaunchFileError,
│   │       BadLaunchArgumentError
│   ├── TooManyCallsError a client has too many calls that wait for their answers
│   ├── WouldDeadlockError  a blocking call that waits for its own thread or group
│   └── DeadlockError     in virtual time every thread waits and nothing is due
├── RemoteError           a peer sent something that breaks the rules
│   └── DecodeError       bytes that are no message of the expected type (also a ValueError)
├── TransportError        the wire itself failed: no session, refused configuration
├── BagError              a bag cannot be read, or cannot be written
├── MissionError          a durable mission, or its journal, did not do what was asked
│   ├── JournalError      the journal cannot be opened, read or written
│   ├── MissionIdTaken    a mission has the id already, with other arguments (also a ValueError)
│   ├── MissionFailed     a mission ended without success
│   ├── MissionStopped    raised in a mission: it was cancelled, gave up, or its time is over
│   ├── StepFailed        raised in a mission: own code of a step raised
│   └── StepLost          raised in a mission: nobody knows whether the step happened
├── TimeoutException      an executor's time was up
├── ConditionReachedException  the condition that a spin waited for is true
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

Errors that are always turned into one of these errors stay in the module that raises them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from goalwire.files import show

if TYPE_CHECKING:
    from enum import IntEnum

    class _Type(Protocol):
        @property
        def name(self) -> str: ...

    class _Parameter(Protocol):
        """The parameter that an error names."""

        @property
        def name(self) -> str: ...
        @property
        def type_(self) -> _Type: ...
        @property
        def value(self) -> object: ...


PEER_TEXT_LIMIT = 500
"""The largest number of characters that errors and logs show of a text that a peer sent."""

_CONTROLS = (
    *range(0x20), *range(0x7F, 0xA0),  # C0, DEL, C1: line breaks, terminal escapes
    # characters that change the writing direction of a text
    0x061C, 0x200E, 0x200F, *range(0x202A, 0x202F), *range(0x2066, 0x206A),
    0x2028, 0x2029,  # further line breaks
)  # fmt: skip
_ESCAPED = {code: chr(code).encode('unicode_escape').decode() for code in _CONTROLS}


def did_you_mean(near: Iterable[str]) -> str:
    """Return "did you mean 'a' or 'b'?" for the names that were probably meant; '' if there are none."""
    quoted = [name if name.startswith("'") else f"'{name}'" for name in near]
    return f'did you mean {" or ".join(quoted)}?' if quoted else ''


def with_advice(text: str, advice: str) -> str:
    """Return a text and the advice what to do next as one line, joined by '; ', or by a space after '?'."""
    if not text or not advice:
        return text or advice
    return f'{text}{" " if text.endswith("?") else "; "}{advice}'


def peer_text(text: object, limit: int = PEER_TEXT_LIMIT) -> str:
    r"""Return a text that a peer sent as one line of at most `limit` characters, for an error or a log.

    Control characters are escaped (`\n`, `\x1b`): so a peer can neither forge lines nor control a terminal. A
    text that this function has returned before stays unchanged.
    """
    told = str(text)[: limit + 1].translate(_ESCAPED)
    return told if len(told) <= limit else told[: limit - 1] + '…'


LONGEST_SHOWN = 255
"""The number of characters that an error shows of a name more than twice as long. DDS allows no
longer names.
"""


def point_at(kind: str, name: str, reason: str, index: int) -> str:
    """Return ROS 2's text for a forbidden name. Of a name that is far too long, only the part around the
    fault is shown.
    """
    length = len(name)
    if length > 2 * LONGEST_SHOWN:
        start = max(0, min(index - LONGEST_SHOWN // 2, length - LONGEST_SHOWN))
        end = start + LONGEST_SHOWN
        name = f'{"…" if start else ""}{name[start:end]}{"…" if end < length else ""}'
        index += (1 if start else 0) - start
        reason = f'{reason} (it has {length:,} characters)'
    return f"Invalid {kind}: {reason}:\n  '{name}'\n   {' ' * index}^"


class GoalwireError(Exception):
    """The base class of all errors that goalwire raises."""


class LocalError(GoalwireError):
    """The calling program made a mistake."""


class ClosedError(LocalError):
    """A context, node or endpoint was used after it was closed."""


class InvalidHandle(ClosedError):
    """A destroyed entity was used (rclpy.exceptions.InvalidHandle)."""

    def __init__(self, message: str = 'cannot use Destroyable because destruction was requested') -> None:
        super().__init__(message)


class DestroyedError(InvalidHandle, RuntimeError):
    """A destroyed entity was used in a call for which rclpy raises RuntimeError."""


class ShutdownException(ClosedError):
    """The executor was shut down."""


class ExternalShutdownException(ClosedError):
    """The context was shut down: by rclpy.shutdown(), or by a signal."""


class NotInitializedException(LocalError):
    """rclpy.init() has not been called (rclpy.exceptions)."""

    def __init__(self, message: str | None = None) -> None:
        text = 'rclpy.init() has not been called'
        super().__init__(f'{text}. msg:{message}' if message else f'{text}.')
        self.add_note('call rclpy.init() before this line; after rclpy.shutdown(), call it again')


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


class RCLError(LocalError, RuntimeError):
    """A call failed in a way in which a function of rcl, ROS 2's C library, would fail."""


class RMWError(LocalError, RuntimeError):
    """Never raised by goalwire. Programs catch it, since rclpy raises it if its middleware fails."""


class RCUtilsError(LocalError, RuntimeError):
    """Never raised by goalwire. Programs catch it, since rclpy raises it if rcutils fails."""


class ShutDownError(RCLError, ClosedError):
    """An entity was used after the end of its context."""

    def __init__(self, what: str) -> None:
        super().__init__(f'{what}: the context was shut down; do this before, or ask rclpy.ok() first')


class ShutDownBySignalError(ShutDownError, ExternalShutdownException):
    """An entity was used after a signal had ended its context.

    Programs that expect a signal catch ExternalShutdownException around their spin. So they end as usual,
    too, if a callback publishes just after the signal.
    """


class RCLInvalidROSArgsError(RCLError):
    """Arguments after --ros-args cannot be parsed."""


class UnknownROSArgsError(RCLError):
    """There are arguments after --ros-args that ROS 2 does not know."""


class UnsupportedEventTypeError(RCLError):
    """The wire in use cannot report this kind of event (rclpy.event_handler)."""

    def __init__(self, event: str, topic: str, wire: str) -> None:
        super().__init__(
            f"Failed to initialize event: {event} is not supported by {wire} (topic '{topic}'): "
            f'leave this callback out on this wire'
        )


class NodeNameNonExistentError(RCLError):
    """A query asked about a node that is not in the graph."""


class InterfaceError(LocalError, ImportError):
    """A .msg, .srv or .action cannot be used."""


class InterfaceSyntaxError(InterfaceError):
    """A definition breaks the grammar; `line` and `column` count from 1; 0: the place is unknown."""

    def __init__(self, source: str, line: int, column: int, problem: str) -> None:
        super().__init__(f'{source}:{line}:{column}: {problem}')
        self.source = source
        self.line = line
        self.column = column
        self.problem = problem


class UnknownInterfaceError(InterfaceError):
    """There is no such interface package, or the package has no such type."""


class NoTypeSupportImportedException(LocalError):
    """A class that was given as a message type has no type support."""

    def __init__(self) -> None:
        super().__init__('no type_support imported')


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
    """A message's constructor got a keyword that names no field. rosidl raises AssertionError, Python
    TypeError.
    """


class TopicExpansionError(LocalError, ValueError):
    """No fully-qualified name can be made of a topic name, node name or namespace."""

    def __init__(self, kind: str, name: str, reason: str) -> None:
        what = 'node namespace' if kind == 'namespace' else kind
        super().__init__(f"{what} '{show(name, LONGEST_SHOWN)}' is invalid: {show(reason, LONGEST_SHOWN)}")
        self.reason = reason


class NameValidationException(LocalError):
    """ROS 2 forbids a name, for the given `reason`; the text points at the wrong character."""

    def __init__(self, name_type: str, name: str, error_msg: str, invalid_index: int) -> None:
        self.reason = error_msg
        super().__init__(point_at(name_type, name, error_msg, invalid_index))
        if (better := _find_allowed_name(name_type, name)) != name:
            self.add_note(f"use letters, digits and '_', and begin with a letter: write {better!r}")


def _find_allowed_name(name_type: str, name: str) -> str:
    """Return a similar name that is allowed; `name` itself if more is wrong with it than
    single characters.
    """
    if not name or len(name) > LONGEST_SHOWN or re.search(r'[~{}]|//|/$', name):
        return name
    others = r'[^A-Za-z0-9_]+' if name_type == 'node name' else r'[^A-Za-z0-9_/]+'
    return re.sub(r'(^|/)(?=[0-9])', r'\1my_', re.sub(others, '_', name))


class InvalidNodeNameException(NameValidationException):
    """ROS 2 forbids this node name."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('node name', name, error_msg, invalid_index)


class InvalidNamespaceException(NameValidationException):
    """ROS 2 forbids this namespace."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('namespace', name, error_msg, invalid_index)


class InvalidTopicNameException(NameValidationException):
    """ROS 2 forbids this topic name."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('topic name', name, error_msg, invalid_index)


class InvalidServiceNameException(NameValidationException):
    """ROS 2 forbids this service name."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('service name', name, error_msg, invalid_index)


class ParameterException(LocalError):
    """A parameter was used in a way that is not allowed."""

    def __init__(self, error_msg: str, parameters: object, advice: str = '') -> None:
        super().__init__(f'{error_msg}: {parameters}')
        if advice:
            self.add_note(advice)


class ParameterNotDeclaredException(ParameterException):
    """A parameter was used that was never declared."""

    def __init__(self, parameters: object, hint: str = '') -> None:
        super().__init__('Invalid access to undeclared parameter(s)', parameters, hint)


class ParameterAlreadyDeclaredException(ParameterException):
    """A parameter was declared twice."""

    def __init__(self, parameters: object) -> None:
        super().__init__(
            'Parameter(s) already declared', parameters, "declare each once, or ask 'has_parameter()' before"
        )


class InvalidParameterException(ParameterException):
    """ROS 2 forbids this parameter name."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__('Invalid parameter name', parameter_name)


class InvalidParameterTypeException(ParameterException):
    """A parameter was to be set to a value of another type than its own."""

    def __init__(self, desired_parameter: _Parameter, expected_type: str) -> None:
        value, name = str(desired_parameter.value), desired_parameter.name
        super().__init__(
            f"Trying to set parameter '{name}' to '{value}' of type '{desired_parameter.type_.name}', "
            f"expecting type '{expected_type}'",
            name,
        )


class InvalidParameterValueException(ParameterException):
    """The parameter's range or a callback refuses the value."""

    def __init__(self, parameter: str, value: object, reason: str) -> None:
        super().__init__(f'Invalid parameter value ({value}) for parameter. Reason: {reason}', parameter)


class ParameterImmutableException(ParameterException):
    """A read-only parameter was to be changed."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__('Attempted to modify read-only parameter', parameter_name)


class ParameterUninitializedException(ParameterException):
    """A parameter was read that has a type but no value yet."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__(f"The parameter '{parameter_name}' is not initialized", parameter_name)


class CallbackError(LocalError, TypeError):
    """A pre-set callback for parameters returned something else than a list of parameters."""


class UnknownCallbackError(LocalError, RuntimeError):
    """A callback was to be removed that was never added, or was removed before."""

    def __init__(self) -> None:
        super().__init__("Callback doesn't exist")


class FileShapeError(LocalError, RuntimeError):
    """A YAML file is not a parameter file."""


class InvalidQoSProfileException(LocalError):
    """A QoS profile was made without a value that it needs."""

    def __init__(self, *args: object) -> None:
        super().__init__('Invalid QoSProfile', *args)
        self.add_note('give the number of messages that are kept: write QoSProfile(depth=10, …)')


class UnknownPolicyError(LocalError, ValueError):
    """A QoS policy cannot be overridden: it does not exist, or its present value is unknown."""


class UnexpectedOverrideError(LocalError, RuntimeError):
    """A QoS policy cannot have the value that overrides it; the text lists the possible values."""


class InvalidQosOverridesError(LocalError):
    """A program's validation callback refuses the QoS that parameters have set
    (rclpy.qos_overriding_options).
    """


class InvalidTransition(LocalError, RuntimeError):
    """A goal's state does not allow this event; the text is ROS 2's own."""

    def __init__(self, status: IntEnum, event: IntEnum) -> None:
        self.status = status
        self.event = event
        super().__init__(
            'Failed to update goal state: goal_handle attempted invalid transition '
            f'from state {status.name} with event {event.name}'
        )


class GoalIdTaken(LocalError, ValueError):
    """A goal was sent with the id of another goal, which the server knows or this client follows already."""

    def __init__(
        self, goal_id: bytes, problem: str = 'is under way already: give every goal an id of its own'
    ) -> None:
        super().__init__(f'goal {goal_id.hex()} {problem}')


class UnknownSeverityError(LocalError, RuntimeError):
    """No severity of log messages has that name."""


class LoggingOptionError(LocalError, TypeError):
    """A log call has an unknown option, or lacks an option that it needs."""


class LoggerNameError(LocalError, ValueError):
    """A logger was to be made without a name."""


class ChangedCallError(LocalError, ValueError):
    """One log call in the source was used with different names, severities or filters."""


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


class WouldDeadlockError(LocalError, RuntimeError):
    """A blocking call would wait for ever: its answer needs the thread or callback group that would wait."""


class TooManyCallsError(LocalError, RuntimeError):
    """A client has so many unanswered calls that it seems to leak them."""


class NotAllowedError(LocalError):
    """The console or a bridge does not allow a request, because of its options or because too many are under
    way.
    """


class FieldValueError(LocalError, ValueError):
    """A value does not fit its field or parameter, which `path` names.

    The path is '' if the whole message does not fit. `problem` says which value was given and which is
    needed; `reason` is the same text without the type at its end.
    """

    def __init__(self, path: str, reason: str, type_text: str = '') -> None:
        problem = f'{reason} ({type_text})' if type_text else reason
        super().__init__(f'{path}: {problem}' if path else problem)
        self.path = path
        self.problem = problem
        self.reason = reason


class LaunchError(LocalError, RuntimeError):
    """A launch file asks for something that cannot be done. `located` is True if the text begins with file
    and line.
    """

    def __init__(self, text: str = '', *, located: bool = False) -> None:
        super().__init__(text)
        self.located = located


class BadLaunchValueError(LaunchError, TypeError, ValueError):
    """An action or a parameter in a launch file was given a value of another type than it takes."""


class InvalidLaunchFileError(LaunchError):
    """A file is not a launch file, or breaks the rules of its format."""

    def __init__(
        self,
        text: str = '',
        *,
        located: bool = False,
        extension: str = '',
        likely_errors: Sequence[Exception] = (),
    ) -> None:
        """Without `text`, the text is made of `likely_errors`, which reading a file with this `extension` has
        raised.
        """
        if likely_errors and not text:
            reasons = '; '.join(f'{type(error).__name__}: {error}' for error in likely_errors)
            text = f"a file ending with '{extension}' cannot be read as a launch file: {reasons}"
            self.__cause__ = likely_errors[0]
        super().__init__(text or 'the launch file cannot be read', located=located)


class InvalidFrontendLaunchFileError(InvalidLaunchFileError):
    """A launch file in XML or YAML breaks the rules of its format."""


class SubstitutionFailure(LaunchError):
    """A substitution in a launch file has no value."""


class InvalidConditionExpressionError(LaunchError):
    """The value of a condition in a launch file is neither true nor false."""


class NoSuchPackageError(LaunchError):
    """No package has that name."""


class NoLaunchFileError(LaunchError, FileNotFoundError):
    """A package has no launch file of that name, or there is none at that path."""


class BadLaunchArgumentError(LaunchError):
    """A word on the command line of a launch does not have the form `name:=value`."""


class DeadlockError(LocalError):
    """In virtual time every thread waits without a deadline, so that no wait could ever end."""


class RemoteError(GoalwireError):
    """A peer sent something that breaks the rules; `peer_text` makes the text of the error safe to show."""

    def __init__(self, message: str = '') -> None:
        super().__init__(peer_text(message))


class DecodeError(RemoteError, ValueError):
    """The bytes are not a message of type `type_name`; `offset` is the position of the fault, header
    included.
    """

    def __init__(self, type_name: str, field: str, offset: int, problem: str) -> None:
        where = f'{field}: ' if field else ''
        super().__init__(f'{type_name}: {where}at byte {offset}: {problem}')
        self.type_name = type_name
        self.field = field
        self.offset = offset


class TransportError(GoalwireError):
    """The wire itself failed, for example because no session could be opened."""


class AddressTakenError(TransportError):
    """A session cannot listen at its address, since another program does."""


class SecurityError(GoalwireError):
    """A keystore, an identity or a policy cannot be used as asked."""


class PolicyError(SecurityError):
    """A policy.toml breaks its grammar; `line` and `column` count from 1."""

    def __init__(self, title: str, place: tuple[int, int], problem: str) -> None:
        self.line, self.column = place
        super().__init__(f'{title}:{self.line}:{self.column}: {problem}')


class BagError(GoalwireError):
    """A bag cannot be read, or cannot be written."""


class MissionError(GoalwireError):
    """The base class of the errors of durable missions and their journals."""


class JournalError(MissionError):
    """A journal cannot be opened, read or written, or another runner has opened it."""


class MissionIdTaken(MissionError, ValueError):
    """A mission with that id was started before, under another name or with other arguments."""


class MissionFailed(MissionError):
    """A mission ended without success, or was cancelled; the text says why."""


class MissionStopped(MissionError):
    """Raised in a mission's code: the mission was cancelled, gave up, or its time is over. Only steps that
    undo what was done are still started.
    """

    def __init__(self, message: str, *, undo: bool = True) -> None:
        super().__init__(message)
        self.undo = undo
        """True if the steps that undo what was done are to run."""


class StepFailed(MissionError):
    """Raised in a mission's code: a function that `m.run` called has raised an error, whose text this error
    has.
    """


class StepLost(MissionError):
    """Raised in a mission's code: nobody knows whether a step happened, and a person or rule decided that it
    counts as failed.
    """


class TimeoutException(GoalwireError):
    """An executor waited for the whole timeout without finding ready work."""


class ConditionReachedException(GoalwireError):
    """The condition that an executor's wait was to end with has become true."""


class CallError(GoalwireError):
    """A call or a goal did not end successfully."""

    def __init__(
        self, message: str = '', *, name: str = '', peers: Sequence[str] = (), waited: float = 0.0
    ) -> None:
        super().__init__(message)
        self.name = name
        """The fully-qualified name of the service or action."""
        self.peers = tuple(peers)
        """The nodes that had a server of that name when the call was made."""
        self.waited = waited
        """The time in s for which the caller has waited."""


class NoRobotError(GoalwireError, LookupError):
    """No robot of a fleet has that name, or a name that matches that pattern."""

    def __init__(self, robot: str, known: Iterable[str]) -> None:
        """`known` are the names of the existing robots; the text suggests the names that were
        probably meant.
        """
        from difflib import get_close_matches

        self.robot = robot
        self.known = tuple(known)
        near = did_you_mean(get_close_matches(robot, self.known, 3, 0.6))
        shown = ', '.join(map(peer_text, self.known[:10])) + (', …' if self.known[10:] else '')
        there = f'there are: {shown}' if self.known else 'there are no robots'
        super().__init__(with_advice(f"there is no robot '{robot}'", near or there))


class NoServerError(CallError, TimeoutError):
    """No server with that name appeared in time."""


class DeadlineError(CallError, TimeoutError):
    """The answer to a call or goal did not come in time."""


class ServerLostError(CallError):
    """The server disappeared before it answered, or no longer knows the goal."""


class ServerStuckError(CallError):
    """The goal's server sent no sign of life for longer than the `heartbeat` that the caller has set."""


class ServerFailedError(CallError):
    """The server did not finish the request: the server's callback failed, or was stopped."""


class RefusedError(CallError):
    """The server did not accept the request: it is too busy, or cannot decode the request."""


class PermissionDeniedError(RefusedError):
    """The server's policy does not allow this identity to call it; the text names the identity, the service
    or action, and the rule.
    """


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
        """The result that the server sent; a result with default values if it sent none."""


class GoalAborted(GoalFailed):
    """The goal was aborted. If an action server's handler raises this error, its goal ends as aborted."""


class GoalCanceled(GoalFailed):
    """The goal was cancelled."""
