"""Goal ids between their sixteen bytes and unique_identifier_msgs/msg/UUID."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.rules.goals.ids import ID_LENGTH, GoalId

if TYPE_CHECKING:
    from unique_identifier_msgs.msg import UUID


def uuid_message(goal_id: GoalId) -> UUID:
    """Return the UUID message of an id."""
    from unique_identifier_msgs.msg import UUID

    return UUID(uuid=list(goal_id))


def goal_id_bytes(uuid: UUID) -> GoalId:
    """Return the id of a UUID message; raises AttributeError for another type, ValueError for its length."""
    goal_id = bytes(uuid.uuid)
    if len(goal_id) != ID_LENGTH:
        raise ValueError(f'a goal id has {ID_LENGTH} bytes, got {len(goal_id)}')
    return goal_id
