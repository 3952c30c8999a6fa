"""rclpy.parameter_service: services to read and set a node's parameters from other nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.entities.parameters.services import ParameterServices
from rclpy._reexports import reexport

if TYPE_CHECKING:
    from rclpy.impl.base_node import BaseNode


class ParameterService:
    """Offers the six parameter services of a node. By default the node's constructor makes one."""

    def __init__(self, node: BaseNode) -> None:
        ParameterServices(node).offer()


reexport(__name__)
