"""rclpy.type_description_service: the service by which a node describes the types that it uses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from goalwire.entities.type_description import START_PARAMETER, TypeDescriptions
from rclpy._reexports import reexport

if TYPE_CHECKING:
    from goalwire.entities.parameters.node_parameters import NodeParameters
    from rclpy.service import Service

START_TYPE_DESCRIPTION_SERVICE_PARAM = START_PARAMETER


@runtime_checkable
class _ListsServices(Protocol):
    def destroy_service(self, service: Service[Any, Any], /) -> bool:
        """Destroy a service; False if the node does not have it."""


class TypeDescriptionService:
    """Offers the service `~/get_type_description` of a node, unless a parameter of the node disables it."""

    def __init__(self, node: NodeParameters) -> None:
        descriptions = TypeDescriptions(node)
        self._node = node
        self.enabled = descriptions.wanted()
        self._service: Service[Any, Any] | None = None
        if self.enabled:
            self._service = descriptions.offer()

    def destroy(self) -> None:
        """Stop offering the service. Idempotent."""
        service, self._service = self._service, None
        if service is None or (
            isinstance(self._node, _ListsServices) and self._node.destroy_service(service)
        ):
            return
        service.destroy()  # a service of an AsyncNode removes itself from the node's list


reexport(__name__)
