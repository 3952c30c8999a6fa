"""rclpy.lifecycle.publisher: a publisher that is silent unless its node is active."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.entities.lifecycle.managed_entity import SimpleManagedEntity
from goalwire.entities.type_support import MsgT
from rclpy._reexports import reexport
from rclpy.publisher import Publisher

if TYPE_CHECKING:
    from goalwire.entities.loans import LoanedMessage


class LifecyclePublisher(SimpleManagedEntity, Publisher[MsgT]):
    """Publishes while its node is active. Made by LifecycleNode.create_lifecycle_publisher."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        SimpleManagedEntity.__init__(self)
        Publisher.__init__(self, *args, **kwargs)

    @SimpleManagedEntity.when_enabled
    def publish(self, msg: MsgT | bytes | LoanedMessage[MsgT]) -> None:
        """Publish while the node is active; otherwise do nothing. Raises as Publisher.publish does."""
        Publisher.publish(self, msg)


reexport(__name__)
