"""rclpy.wait_for_message: waits for one message of a topic."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeVar

from goalwire.entities import subscription as entity
from rclpy._reexports import reexport
from rclpy.qos import QoSProfile

if TYPE_CHECKING:
    from rclpy.impl.base_node import BaseNode

__all__ = ['wait_for_message']

MsgT = TypeVar('MsgT')


def wait_for_message(
    msg_type: type[MsgT],
    node: BaseNode,
    topic: str,
    *,
    qos_profile: QoSProfile | int = 1,
    time_to_wait: float = -1,
) -> tuple[Literal[True], MsgT] | tuple[Literal[False], None]:
    """Wait for a message and return (True, message), or (False, None) after `time_to_wait` s or at shutdown.

    A negative time means no limit. The node need not spin. Raises as Node.create_subscription does.
    """
    profile = QoSProfile.of(qos_profile)
    message = entity.wait_for_message(node.handle, msg_type, topic, profile.to_core(), time_to_wait)
    return (False, None) if message is None else (True, message)


reexport(__name__)
