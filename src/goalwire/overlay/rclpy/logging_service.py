"""rclpy.logging_service: services to read and set the levels of loggers from other nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.entities.builtin_services import offer_logger_services
from rclpy._reexports import reexport

if TYPE_CHECKING:
    from rclpy.impl.base_node import BaseNode


class LoggingService:
    """Offers a node's two services for logger levels.

    A node makes one such object if `enable_logger_service` is True.
    """

    def __init__(self, node: BaseNode) -> None:
        offer_logger_services(node.handle)


reexport(__name__)
