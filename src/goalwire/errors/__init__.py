"""Every error that goalwire raises, in one tree; the modules rclpy and tf2 re-export theirs from here.

Each family has a file. Programs import every error from this package, and every error names it as its module.

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
│   ├── FieldValueError   a value does not fit its field or parameter (also a ValueError)
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
│   │       BadLaunchArgumentError, BadLaunchValueError
│   ├── NotAllowedError   the console or a bridge does not allow a request
│   ├── TooManyCallsError a client has too many calls that wait for their answers
│   ├── WouldDeadlockError  a blocking call that waits for its own thread or group
│   └── DeadlockError     in virtual time every thread waits and nothing is due
├── RemoteError           a peer sent something that breaks the rules
│   └── DecodeError       bytes that are no message of the expected type (also a ValueError)
├── TransportError        the wire itself failed: no session, refused configuration
│   └── AddressTakenError another program listens at the address
├── SecurityError         a keystore, an identity or a policy cannot be used
│   └── PolicyError       a policy.toml breaks its grammar
├── BagError              a bag cannot be read, or cannot be written
├── MissionError          a durable mission, or its journal, did not do what was asked
│   ├── JournalError      the journal cannot be opened, read or written
│   ├── MissionIdTaken    a mission has the id already, with other arguments (also a ValueError)
│   ├── MissionFailed     a mission ended without success
│   ├── MissionStopped    raised in a mission: it was cancelled, gave up, or its time is over
│   ├── StepFailed        raised in a mission: own code of a step raised
│   └── StepLost          raised in a mission: nobody knows whether the step happened
├── NoRobotError          a fleet has no such robot (also a LookupError)
├── TimeoutException      an executor's time was up
├── ConditionReachedException  the condition that a spin waited for is true
└── CallError             a call or goal that did not end well
    ├── NoServerError     nobody served that name in time (also a TimeoutError)
    ├── DeadlineError     the answer did not come in time (also a TimeoutError)
    ├── ServerLostError   the server went away before it answered
    ├── ServerStuckError  the goal's server gave no sign of life for too long
    ├── ServerFailedError the server gave the request up: its callback failed
    ├── RefusedError      the server did not take the request
    │   ├── PermissionDeniedError  … since its policy forbids it
    │   └── GoalRefused   the action server did not accept the goal
    └── GoalFailed        the goal ended without success
        ├── GoalAborted   … since it could not be reached
        └── GoalCanceled  … since it was cancelled

Errors that are always turned into one of these errors stay in the module that raises them.
"""

from __future__ import annotations

from goalwire.errors.base import (
    AddressTakenError,
    BagError,
    ChangedCallError,
    GoalwireError,
    LocalError,
    LoggerNameError,
    LoggingOptionError,
    NotAllowedError,
    PolicyError,
    RemoteError,
    SecurityError,
    TransportError,
    UnknownSeverityError,
)
from goalwire.errors.calls import (
    CallError,
    DeadlineError,
    DeadlockError,
    GoalAborted,
    GoalCanceled,
    GoalFailed,
    GoalIdTaken,
    GoalRefused,
    InvalidTransition,
    NoServerError,
    PermissionDeniedError,
    RefusedError,
    ServerFailedError,
    ServerLostError,
    ServerStuckError,
    TooManyCallsError,
    WouldDeadlockError,
)
from goalwire.errors.contexts import (
    ClosedError,
    ConditionReachedException,
    DestroyedError,
    ExternalShutdownException,
    ForkedError,
    InvalidHandle,
    NodeNameNonExistentError,
    NotInitializedException,
    RCLError,
    RCLInvalidROSArgsError,
    RCUtilsError,
    RMWError,
    ROSInterruptException,
    ShutDownBySignalError,
    ShutDownError,
    ShutdownException,
    TimeoutException,
    TimeSourceChangedError,
    UnknownROSArgsError,
    UnsupportedEventTypeError,
)
from goalwire.errors.messages import (
    DecodeError,
    EncodeError,
    EncodeTypeError,
    EncodeValueError,
    FieldValueError,
    InterfaceError,
    InterfaceSyntaxError,
    NoTypeSupportImportedException,
    UnknownFieldError,
    UnknownInterfaceError,
)
from goalwire.errors.names import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    NameValidationException,
    NoRobotError,
    TopicExpansionError,
)
from goalwire.errors.parameters import (
    CallbackError,
    FileShapeError,
    InvalidParameterException,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    InvalidQosOverridesError,
    InvalidQoSProfileException,
    ParameterAlreadyDeclaredException,
    ParameterException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
    UnexpectedOverrideError,
    UnknownCallbackError,
    UnknownPolicyError,
)
from goalwire.errors.wording import (
    LONGEST_SHOWN,
    PEER_TEXT_LIMIT,
    did_you_mean,
    peer_text,
    point_at,
    with_advice,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from goalwire.errors.launching import (
        BadLaunchArgumentError,
        BadLaunchValueError,
        InvalidConditionExpressionError,
        InvalidFrontendLaunchFileError,
        InvalidLaunchFileError,
        LaunchError,
        NoLaunchFileError,
        NoSuchPackageError,
        SubstitutionFailure,
    )
    from goalwire.errors.missions import (
        JournalError,
        MissionError,
        MissionFailed,
        MissionIdTaken,
        MissionStopped,
        StepFailed,
        StepLost,
    )
    from goalwire.errors.transforms import (
        ConnectivityException,
        ExtrapolationException,
        InvalidArgumentException,
        LookupException,
        NotImplementedException,
        RejectedTransform,
        TransformException,
        TransformTimeoutException,
        TypeException,
    )

__all__ = [
    'LONGEST_SHOWN',
    'PEER_TEXT_LIMIT',
    'AddressTakenError',
    'BadLaunchArgumentError',
    'BadLaunchValueError',
    'BagError',
    'CallError',
    'CallbackError',
    'ChangedCallError',
    'ClosedError',
    'ConditionReachedException',
    'ConnectivityException',
    'DeadlineError',
    'DeadlockError',
    'DecodeError',
    'DestroyedError',
    'EncodeError',
    'EncodeTypeError',
    'EncodeValueError',
    'ExternalShutdownException',
    'ExtrapolationException',
    'FieldValueError',
    'FileShapeError',
    'ForkedError',
    'GoalAborted',
    'GoalCanceled',
    'GoalFailed',
    'GoalIdTaken',
    'GoalRefused',
    'GoalwireError',
    'InterfaceError',
    'InterfaceSyntaxError',
    'InvalidArgumentException',
    'InvalidConditionExpressionError',
    'InvalidFrontendLaunchFileError',
    'InvalidHandle',
    'InvalidLaunchFileError',
    'InvalidNamespaceException',
    'InvalidNodeNameException',
    'InvalidParameterException',
    'InvalidParameterTypeException',
    'InvalidParameterValueException',
    'InvalidQoSProfileException',
    'InvalidQosOverridesError',
    'InvalidServiceNameException',
    'InvalidTopicNameException',
    'InvalidTransition',
    'JournalError',
    'LaunchError',
    'LocalError',
    'LoggerNameError',
    'LoggingOptionError',
    'LookupException',
    'MissionError',
    'MissionFailed',
    'MissionIdTaken',
    'MissionStopped',
    'NameValidationException',
    'NoLaunchFileError',
    'NoRobotError',
    'NoServerError',
    'NoSuchPackageError',
    'NoTypeSupportImportedException',
    'NodeNameNonExistentError',
    'NotAllowedError',
    'NotImplementedException',
    'NotInitializedException',
    'ParameterAlreadyDeclaredException',
    'ParameterException',
    'ParameterImmutableException',
    'ParameterNotDeclaredException',
    'ParameterUninitializedException',
    'PermissionDeniedError',
    'PolicyError',
    'RCLError',
    'RCLInvalidROSArgsError',
    'RCUtilsError',
    'RMWError',
    'ROSInterruptException',
    'RefusedError',
    'RejectedTransform',
    'RemoteError',
    'SecurityError',
    'ServerFailedError',
    'ServerLostError',
    'ServerStuckError',
    'ShutDownBySignalError',
    'ShutDownError',
    'ShutdownException',
    'StepFailed',
    'StepLost',
    'SubstitutionFailure',
    'TimeSourceChangedError',
    'TimeoutException',
    'TooManyCallsError',
    'TopicExpansionError',
    'TransformException',
    'TransformTimeoutException',
    'TransportError',
    'TypeException',
    'UnexpectedOverrideError',
    'UnknownCallbackError',
    'UnknownFieldError',
    'UnknownInterfaceError',
    'UnknownPolicyError',
    'UnknownROSArgsError',
    'UnknownSeverityError',
    'UnsupportedEventTypeError',
    'WouldDeadlockError',
    'did_you_mean',
    'peer_text',
    'point_at',
    'with_advice',
]

# Each of these families is imported when one of its errors is first needed: most programs need none.
_LATER = {
    'launching': (
        'BadLaunchArgumentError BadLaunchValueError InvalidConditionExpressionError '
        'InvalidFrontendLaunchFileError InvalidLaunchFileError LaunchError NoLaunchFileError '
        'NoSuchPackageError SubstitutionFailure'
    ),
    'missions': 'JournalError MissionError MissionFailed MissionIdTaken MissionStopped StepFailed StepLost',
    'transforms': (
        'ConnectivityException ExtrapolationException InvalidArgumentException LookupException '
        'NotImplementedException RejectedTransform TransformException TransformTimeoutException TypeException'
    ),
}
_FILES = {name: file for file, names in _LATER.items() for name in names.split()}

if not TYPE_CHECKING:  # a type checker would take any name that this function might find

    def __getattr__(name: str) -> object:
        file = _FILES.get(name)
        if file is None:
            raise AttributeError(f"module 'goalwire.errors' has no attribute '{name}'")
        from importlib import import_module

        found: object = getattr(import_module(f'{__name__}.{file}'), name)
        globals()[name] = found
        return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_FILES})
