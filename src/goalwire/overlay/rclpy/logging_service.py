"""rclpy.logging_service: through which others read and set the levels of loggers."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from goalwire.entities.logger_services import offer_logger_services
from rclpy._reexports import reexport
from rclpy.qos import qos_profile_services_default

if TYPE_CHECKING:
    from rclpy.impl.base_node import BaseNode


class LoggingService:
    """Offers a node's two services; its constructor makes one where `enable_logger_service` asks for it."""

    def __init__(self, node: BaseNode) -> None:
        make = partial(node._ros_offer, qos_profile=qos_profile_services_default)  # noqa: SLF001 - of one house
        offer_logger_services(node.get_name(), make)


reexport(__name__)
