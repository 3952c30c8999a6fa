"""The types of an action for type checkers (goal, result, feedback), and goal ids as messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeAlias, TypeVar

from goalwire.rules.goals.ids import ID_LENGTH, GoalId

if TYPE_CHECKING:
    from typing_extensions import TypeVar as TypeVarWithDefault
    from unique_identifier_msgs.msg import UUID

    # Only type checkers need defaults: programs may write a bare ServerGoalHandle, as rclpy's own do.
    GoalT = TypeVarWithDefault('GoalT', default=Any)
    ResultT = TypeVarWithDefault('ResultT', default=Any)
    FeedbackT = TypeVarWithDefault('FeedbackT', default=Any)
else:
    GoalT = TypeVar('GoalT')
    ResultT = TypeVar('ResultT')
    FeedbackT = TypeVar('FeedbackT')

GoalT_co = TypeVar('GoalT_co', covariant=True)
ResultT_co = TypeVar('ResultT_co', covariant=True)
FeedbackT_co = TypeVar('FeedbackT_co', covariant=True)


class ActionType(Protocol[GoalT_co, ResultT_co, FeedbackT_co]):
    """An action class."""

    @property
    def Goal(self) -> type[GoalT_co]:  # noqa: N802 - rosidl's name
        """The action's Goal class."""

    @property
    def Result(self) -> type[ResultT_co]:  # noqa: N802
        """The action's Result class."""

    @property
    def Feedback(self) -> type[FeedbackT_co]:  # noqa: N802
        """The action's Feedback class."""


class BareAction(Protocol):
    """An action class as the checker pyrefly sees it: for pyrefly a nested class is not a property."""

    Goal: ClassVar[type[Any]]
    Result: ClassVar[type[Any]]
    Feedback: ClassVar[type[Any]]


ActionClass: TypeAlias = type[ActionType[GoalT, ResultT, FeedbackT]] | type[BareAction]
"""An action class, as ActionServer and ActionClient take it."""


class ResultResponse(Protocol[ResultT_co]):
    """The action's GetResult response, which the future of a result gives."""

    @property
    def status(self) -> int:
        """How the goal ended, an action_msgs/msg/GoalStatus number."""

    @property
    def result(self) -> ResultT_co:
        """The result; one of default values if the server sent none."""


class FeedbackMessage(Protocol[FeedbackT_co]):
    """The action's FeedbackMessage, which a feedback callback gets."""

    @property
    def goal_id(self) -> UUID:
        """The id of the goal that the feedback belongs to."""

    @property
    def feedback(self) -> FeedbackT_co:
        """The feedback that the server published."""


FeedbackMessageT = TypeVar('FeedbackMessageT', bound=FeedbackMessage[Any])
"""A type variable for callbacks that are annotated with the action's own Impl.FeedbackMessage."""


def uuid_message(goal_id: GoalId) -> UUID:
    """Return the UUID message of an id."""
    from unique_identifier_msgs.msg import UUID

    return UUID(uuid=goal_id)


def goal_id_bytes(uuid: UUID) -> GoalId:
    """Return the id of a UUID message; raises AttributeError for another type, ValueError for a bad size."""
    goal_id = bytes(uuid.uuid)
    if len(goal_id) != ID_LENGTH:
        raise ValueError(f'a goal id has {ID_LENGTH} bytes, got {len(goal_id)}')
    return goal_id
