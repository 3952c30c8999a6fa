"""rclpy.type_support: checks whether a class is a message, service or action; types for annotations.

The generic names are those of rclpy 9 (ROS 2 Kilted); `MsgType` and similar names are those of rclpy 7.
"""

from typing import TYPE_CHECKING, Protocol, TypeAlias, TypeVar

from goalwire.entities.type_support import (
    check_for_type_support,
    check_is_valid_msg_type,
    check_is_valid_srv_type,
)
from rclpy._reexports import reexport

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time
    from unique_identifier_msgs.msg import UUID

__all__ = [
    'Action',
    'ActionT',
    'FeedbackMessage',
    'FeedbackT',
    'GetResultService',
    'GetResultServiceRequest',
    'GetResultServiceResponse',
    'GoalT',
    'Msg',
    'MsgT',
    'ResultT',
    'SendGoalService',
    'SendGoalServiceRequest',
    'SendGoalServiceResponse',
    'Srv',
    'SrvRequestT',
    'SrvResponseT',
    'SrvT',
    'check_for_type_support',
    'check_is_valid_msg_type',
    'check_is_valid_srv_type',
]

MsgType = TypeVar('MsgType')
SrvType = TypeVar('SrvType')
SrvTypeRequest = TypeVar('SrvTypeRequest')
SrvTypeResponse = TypeVar('SrvTypeResponse')

MsgT = TypeVar('MsgT')
SrvT = TypeVar('SrvT')
SrvRequestT = TypeVar('SrvRequestT')
SrvResponseT = TypeVar('SrvResponseT')
ActionT = TypeVar('ActionT')
GoalT = TypeVar('GoalT')
ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')


class Msg(Protocol):
    """A message."""


class Srv(Protocol):
    """A service's class."""


class Action(Protocol):
    """An action's class."""


class SendGoalServiceRequest(Msg, Protocol[GoalT]):
    """The request of an action's SendGoal service."""

    goal_id: 'UUID'
    goal: GoalT


class SendGoalServiceResponse(Msg, Protocol):
    """The response to a goal: whether it was accepted."""

    accepted: bool
    stamp: 'Time'


class GetResultServiceRequest(Msg, Protocol):
    """The request of an action's GetResult service."""

    goal_id: 'UUID'


class GetResultServiceResponse(Msg, Protocol[ResultT]):
    """The response with a goal's status and result."""

    status: int
    result: ResultT


class FeedbackMessage(Msg, Protocol[FeedbackT]):
    """The message of an action's feedback topic."""

    goal_id: 'UUID'
    feedback: FeedbackT


SendGoalService: TypeAlias = Srv
GetResultService: TypeAlias = Srv

reexport(__name__)
