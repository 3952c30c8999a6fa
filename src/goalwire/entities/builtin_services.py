"""The services that every node offers by itself: for parameters, loggers and type descriptions."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from goalwire.entities.parameters.services import ParameterServices
from goalwire.entities.standard_types import standard_service
from goalwire.logging import get_logger_level, set_logger_level
from goalwire.rules.qos import SERVICES_DEFAULT

if TYPE_CHECKING:
    from collections.abc import Callable

    from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels

    from goalwire.entities.node import NodeCore
    from goalwire.entities.parameters.node_parameters import NodeParameters

NodeT = TypeVar('NodeT', bound='NodeParameters')
DescriberT = TypeVar('DescriberT')


def start_builtin_services(
    node: NodeT, describe: Callable[[NodeT], DescriberT], *, parameters: bool = True, loggers: bool = False
) -> DescriberT:
    """Make a node's services, in ROS 2's order, and return the one that `describe` makes.

    The parameters must be declared before, for some of them decide which services there are.
    """
    if parameters:
        ParameterServices(node).offer()
    if loggers:
        offer_logger_services(node.handle)
    return describe(node)


def offer_logger_services(node: NodeCore) -> None:
    """Make the services by which others read and set the levels of the process's loggers."""
    for service, type_name, answer in (
        ('get_logger_levels', 'GetLoggerLevels', _get),
        ('set_logger_levels', 'SetLoggerLevels', _set),
    ):
        support = standard_service(f'rcl_interfaces/srv/{type_name}')
        node.make_service(support, f'{node.name.name}/{service}', answer, SERVICES_DEFAULT)


def _get(request: GetLoggerLevels.Request, response: GetLoggerLevels.Response) -> GetLoggerLevels.Response:
    """Answer with the loggers' levels: 0 for a logger without a level of its own; '' is the root logger."""
    from rcl_interfaces.msg import LoggerLevel

    response.levels = [LoggerLevel(name=name, level=int(get_logger_level(name))) for name in request.names]
    return response


def _set(request: SetLoggerLevels.Request, response: SetLoggerLevels.Response) -> SetLoggerLevels.Response:
    """Set the loggers' levels, except unknown levels; 0 gives a logger the level of its ancestors again."""
    from rcl_interfaces.msg import SetLoggerLevelsResult

    for wanted in request.levels:
        result = SetLoggerLevelsResult(successful=True)
        try:
            set_logger_level(wanted.name, wanted.level)
        except ValueError:
            result = SetLoggerLevelsResult(successful=False, reason='Failed reason: Invalid logger level.')
        response.results.append(result)
    return response
