"""rclpy.parameter_service: through which others read and set a node's parameters."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from goalwire.entities.parameters.services import ParameterServices
from rclpy._reexports import reexport
from rclpy.qos import qos_profile_parameters

if TYPE_CHECKING:
    from rclpy.impl.base_node import BaseNode


class ParameterService:
    """Offers the six parameter services of a node; its constructor makes one unless told not to."""

    def __init__(self, node: BaseNode) -> None:
        make = partial(node._ros_offer, qos_profile=qos_profile_parameters)  # noqa: SLF001 - of one house
        ParameterServices(node).offer(make)


reexport(__name__)
