"""rclpy.parameter_service: services by which others read and set a node's parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.entities.parameters.services import ParameterServices
from rclpy._reexports import reexport

if TYPE_CHECKING:
    from rclpy.impl.base_node import BaseNode


class ParameterService:
    """Offers the six parameter services of a node; its constructor makes one unless told not to."""

    def __init__(self, node: BaseNode) -> None:
        ParameterServices(node).offer()


reexport(__name__)
