"""The ROS arguments of a process or a node, with rclpy's exceptions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from goalwire.entities.exceptions import RCLError, RCLInvalidROSArgsError, UnknownROSArgsError
from goalwire.protocol.arguments import (
    ArgumentError,
    Arguments,
    ParameterFile,
    UnknownArguments,
    parse_arguments,
)

if TYPE_CHECKING:
    from goalwire.protocol.parameters import ParameterValue


def process_arguments(args: Sequence[str]) -> Arguments:
    """Read a program's arguments; raises RCLError, UnknownROSArgsError, TypeError for what are no strings."""
    if isinstance(args, str) or not all(isinstance(arg, str) for arg in args):
        raise TypeError(f'args must be a sequence of strings, as sys.argv is; got {args!r}')
    try:
        return parse_arguments(args)
    except UnknownArguments as error:
        raise UnknownROSArgsError(str(error)) from None
    except ArgumentError as error:
        raise RCLError(f'failed to initialize rcl: {error}') from None


def node_arguments(cli_args: Sequence[str] | None) -> Arguments:
    """Read a node's own arguments; raises RCLInvalidROSArgsError or UnknownROSArgsError."""
    if not cli_args:
        return Arguments()
    try:
        return parse_arguments(cli_args)
    except UnknownArguments as error:
        raise UnknownROSArgsError(str(error)) from None
    except ArgumentError as error:
        raise RCLInvalidROSArgsError(f'Failed to parse ROS arguments: {error}') from None


def parameter_overrides(arguments: Arguments, full_node_name: str) -> dict[str, ParameterValue]:
    """Return what `-p` and `--params-file` give to a node's parameters, a later one winning."""
    values: dict[str, ParameterValue] = {}
    for item in arguments.parameters:
        if isinstance(item, ParameterFile):
            from goalwire.entities.parameter_files import parameters_from_file

            values.update(parameters_from_file(item.path, full_node_name))
        elif item.applies_to(full_node_name):
            values[item.name] = item.value
    return values
