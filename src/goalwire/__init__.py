"""goalwire: ROS 2's topics, services and actions for Python, from one pip install.

The names in this module are those of the asyncio API; each is imported when it is first used. Programs for
ROS 2 import rclpy.

PYTEST_DONT_REWRITE: goalwire's .pth file imports this module before pytest can rewrite its asserts. Without
this mark pytest would warn of that in every project.
"""

# Not imported from typing, which would take 5 ms. Without the annotation jedi would take it for False.
TYPE_CHECKING: bool = False

if TYPE_CHECKING:
    from goalwire.aio import ActionClient as ActionClient
    from goalwire.aio import ActionServer as ActionServer
    from goalwire.aio import Client as Client
    from goalwire.aio import Goal as Goal
    from goalwire.aio import GoalProbe as GoalProbe
    from goalwire.aio import GoalState as GoalState
    from goalwire.aio import Node as Node
    from goalwire.aio import Parameters as Parameters
    from goalwire.aio import Publisher as Publisher
    from goalwire.aio import Run as Run
    from goalwire.aio import Service as Service
    from goalwire.aio import Subscription as Subscription
    from goalwire.aio import Timer as Timer
    from goalwire.errors import CallError as CallError
    from goalwire.errors import DeadlineError as DeadlineError
    from goalwire.errors import GoalAborted as GoalAborted
    from goalwire.errors import GoalCanceled as GoalCanceled
    from goalwire.errors import GoalFailed as GoalFailed
    from goalwire.errors import GoalIdTaken as GoalIdTaken
    from goalwire.errors import GoalRefused as GoalRefused
    from goalwire.errors import GoalwireError as GoalwireError
    from goalwire.errors import NoRobotError as NoRobotError
    from goalwire.errors import NoServerError as NoServerError
    from goalwire.errors import RefusedError as RefusedError
    from goalwire.errors import ServerFailedError as ServerFailedError
    from goalwire.errors import ServerLostError as ServerLostError
    from goalwire.errors import ServerStuckError as ServerStuckError
    from goalwire.errors import TooManyCallsError as TooManyCallsError
    from goalwire.rules.goals.journal import GoalJournal as GoalJournal
    from goalwire.rules.goals.policy import GoalPolicy as GoalPolicy
    from goalwire.rules.goals.policy import parallel as parallel
    from goalwire.rules.goals.policy import preempt as preempt
    from goalwire.rules.goals.policy import queue as queue
    from goalwire.rules.goals.policy import single as single
    from goalwire.rules.qos import DurabilityPolicy as DurabilityPolicy
    from goalwire.rules.qos import HistoryPolicy as HistoryPolicy
    from goalwire.rules.qos import LivelinessPolicy as LivelinessPolicy
    from goalwire.rules.qos import QoS as QoS
    from goalwire.rules.qos import ReliabilityPolicy as ReliabilityPolicy
    from goalwire.rules.retries import CallAttempt as CallAttempt
    from goalwire.rules.retries import Retry as Retry

__version__ = '0.1.0'

_NAMES = {
    'goalwire.aio': (
        'ActionClient ActionServer Client Goal GoalProbe GoalState Node Parameters Publisher Run Service '
        'Subscription Timer'
    ),
    'goalwire.errors': (
        'CallError DeadlineError GoalAborted GoalCanceled GoalFailed GoalIdTaken GoalRefused GoalwireError '
        'NoRobotError NoServerError RefusedError ServerFailedError ServerLostError ServerStuckError '
        'TooManyCallsError'
    ),
    'goalwire.rules.goals.journal': 'GoalJournal',
    'goalwire.rules.goals.policy': 'GoalPolicy parallel preempt queue single',
    'goalwire.rules.qos': 'DurabilityPolicy HistoryPolicy LivelinessPolicy QoS ReliabilityPolicy',
    'goalwire.rules.retries': 'CallAttempt Retry',
}
_ORIGINS = {name: origin for origin, names in _NAMES.items() for name in names.split()}


def __getattr__(name: str) -> object:
    origin = _ORIGINS.get(name)
    if origin is None:
        raise AttributeError(f"module 'goalwire' has no attribute '{name}'")
    from importlib import import_module

    found: object = getattr(import_module(origin), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_ORIGINS})
