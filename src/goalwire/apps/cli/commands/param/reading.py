"""Shared by the verbs of `ros2 param`: finds the node and makes its client."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

import goalwire
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.nodes import CALL_S, add_node_argument, add_timeout_argument
from goalwire.observe.parameters import NodeParameters


def parameter_arguments(parser: ArgumentParser) -> None:
    """Add the argument for the node, and the option for how long to wait for the node."""
    add_graph_arguments(parser)
    add_node_argument(parser)
    add_timeout_argument(parser)


def parameters_of(node: goalwire.Node, name: str, arguments: Namespace) -> NodeParameters:
    """Return the parameters of the node of that name."""
    return NodeParameters(node, name, arguments.service_timeout or CALL_S)
