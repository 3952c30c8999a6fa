"""The steps that the construction of action servers and of action clients share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from goalwire.entities.actions.endpoints import ActionQoS
from goalwire.errors import NameValidationException

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile


def action_qos(
    goal: QoSProfile, result: QoSProfile, cancel: QoSProfile, feedback: QoSProfile, status: QoSProfile
) -> ActionQoS:
    """Return an action's five QoS profiles in the form that goalwire's core uses."""
    return ActionQoS(*(profile.to_core() for profile in (goal, result, cancel, feedback, status)))


def check_node(node: object, what: str) -> None:
    """Raise AttributeError if the first argument is not a node; `what` is the constructed class."""
    if not hasattr(node, 'handle') or isinstance(node, type):
        given = node.__name__ if isinstance(node, type) else repr(node)
        raise AttributeError(
            f'the first argument of {what} is the node, got {given}: '
            f"write {what}(node, Fibonacci, 'fibonacci'"
            f'{", execute" if what == "ActionServer" else ""})'
        )


@contextmanager
def refusing_bad_names(what: str, action_name: str) -> Iterator[None]:
    """Turn errors for bad action names into a ValueError with rclpy's message.

    `what` is 'client' or 'server'.
    """
    try:
        yield
    except NameValidationException as error:
        raise ValueError(
            f"Failed to create action {what} due to invalid topic name '{action_name}' : {error}"
        ) from None
