"""The answers that programs for Nav2 wait for: whether its managed nodes are active."""

from __future__ import annotations

from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState


def tell_state(response: GetState.Response, *, is_active: bool) -> GetState.Response:
    """Fill in what a managed node answers; ours is active as soon as it can do its work."""
    response.current_state.id = State.PRIMARY_STATE_ACTIVE if is_active else State.PRIMARY_STATE_INACTIVE
    response.current_state.label = 'active' if is_active else 'inactive'
    return response
