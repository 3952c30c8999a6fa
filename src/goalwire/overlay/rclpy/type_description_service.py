"""rclpy.type_description_service: a node describes the types that it uses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.entities.type_description import START_PARAMETER, TypeDescriptions
from rclpy._reexports import reexport

if TYPE_CHECKING:
    from rclpy.impl.base_node import BaseNode
    from rclpy.service import Service

START_TYPE_DESCRIPTION_SERVICE_PARAM = START_PARAMETER


class TypeDescriptionService:
    """Offers `~/get_type_description`, unless the node's parameter says no."""

    def __init__(self, node: BaseNode) -> None:
        descriptions = TypeDescriptions(node)
        self._node = node
        self.enabled = descriptions.wanted()
        self._service: Service[Any, Any] | None = None
        if self.enabled:
            self._service = descriptions.offer()

    def destroy(self) -> None:
        """Offer it no longer. Idempotent."""
        service, self._service = self._service, None
        if service is not None:
            if service in self._node._services:  # noqa: SLF001
                self._node._services.remove(service)  # noqa: SLF001
            service.destroy()


reexport(__name__)
