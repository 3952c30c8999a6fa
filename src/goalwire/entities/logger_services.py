"""The services through which others read and set the levels of a process's loggers (rcl_interfaces/srv)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.entities.standard_types import MakeService, standard_service
from goalwire.logging import get_logger_level, set_logger_level

if TYPE_CHECKING:
    from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels


def offer_logger_services(node_name: str, make: MakeService[Any]) -> None:
    """Make the services of a node, in ROS 2's order."""
    for service, type_name, answer in (
        ('get_logger_levels', 'GetLoggerLevels', _get),
        ('set_logger_levels', 'SetLoggerLevels', _set),
    ):
        make(standard_service(f'rcl_interfaces/srv/{type_name}'), f'{node_name}/{service}', answer)


def _get(request: GetLoggerLevels.Request, response: GetLoggerLevels.Response) -> GetLoggerLevels.Response:
    """Answer with 0 for a logger without a level of its own; '' is the root."""
    from rcl_interfaces.msg import LoggerLevel

    response.levels = [LoggerLevel(name=name, level=int(get_logger_level(name))) for name in request.names]
    return response


def _set(request: SetLoggerLevels.Request, response: SetLoggerLevels.Response) -> SetLoggerLevels.Response:
    """Set each level that there is; 0 returns a logger to the level of its ancestors."""
    from rcl_interfaces.msg import SetLoggerLevelsResult

    for wanted in request.levels:
        result = SetLoggerLevelsResult(successful=True)
        try:
            set_logger_level(wanted.name, wanted.level)
        except ValueError:
            result = SetLoggerLevelsResult(successful=False, reason='Failed reason: Invalid logger level.')
        response.results.append(result)
    return response
