"""What the verbs of `ros2 param` ask a node."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.nodes import add_node_argument, add_timeout_argument, call

if TYPE_CHECKING:
    import goalwire


def parameter_arguments(parser: ArgumentParser) -> None:
    """Add the node, and how long to wait for it."""
    add_graph_arguments(parser)
    add_node_argument(parser)
    add_timeout_argument(parser)


async def values_of(node: goalwire.Node, name: str, names: list[str], arguments: Namespace) -> list[Any]:
    """Return the ParameterValue messages of a node's parameters; none if it does not have all."""
    from rcl_interfaces.srv import GetParameters

    response = await call(node, GetParameters, f'{name}/get_parameters', arguments, {'names': names})
    found: list[Any] = list(response.values)
    return found


async def descriptors_of(node: goalwire.Node, name: str, names: list[str], arguments: Namespace) -> list[Any]:
    """Return the ParameterDescriptor messages of a node's parameters; none if it does not have all."""
    from rcl_interfaces.srv import DescribeParameters

    response = await call(
        node, DescribeParameters, f'{name}/describe_parameters', arguments, {'names': names}
    )
    found: list[Any] = list(response.descriptors)
    return found
