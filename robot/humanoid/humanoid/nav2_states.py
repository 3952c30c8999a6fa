"""Answers for programs that wait until Nav2's managed nodes are active."""

from __future__ import annotations

from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState


def tell_state(response: GetState.Response, *, is_active: bool) -> GetState.Response:
    """Fill in a managed node's answer: "active" as soon as the node can do its work."""
    response.current_state.id = State.PRIMARY_STATE_ACTIVE if is_active else State.PRIMARY_STATE_INACTIVE
    response.current_state.label = 'active' if is_active else 'inactive'
    return response
