"""Parses the ROS arguments of a process or a node, and raises rclpy's exceptions."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from goalwire.errors import RCLError, RCLInvalidROSArgsError, UnknownROSArgsError
from goalwire.files import show
from goalwire.logging import get_logger
from goalwire.rules.arguments import ArgumentError, Arguments, UnknownArguments, parse_arguments

if TYPE_CHECKING:
    from goalwire.rules.parameters.unused import OverrideUse


def process_arguments(args: Sequence[str]) -> Arguments:
    """Read a program's arguments; raises RCLError, UnknownROSArgsError, TypeError for non-strings."""
    if not _are_strings(args):
        raise TypeError(f'args must be a sequence of strings, as sys.argv is; got {args!r}')
    try:
        arguments = _complete(parse_arguments(args))
    except UnknownArguments as error:
        raise UnknownROSArgsError(str(error)) from None
    except ArgumentError as error:
        raise RCLError(f'failed to initialize rcl: {error}') from None
    _tell_outside(arguments.rest)
    return arguments


def _tell_outside(rest: Sequence[str]) -> None:
    """Warn of a parameter before `--ros-args`, where ROS 2 does not look."""
    for flag, value in pairwise(rest):
        if flag in {'-p', '--param'} and ':=' in value:
            get_logger('rcl').warning(
                f"'{flag} {show(value)}' has no effect: write --ros-args before it, as in "
                f"'--ros-args {flag} {show(value)}'"
            )


def node_arguments(cli_args: Sequence[str] | None) -> Arguments:
    """Read a node's own arguments; raises RCLInvalidROSArgsError or UnknownROSArgsError."""
    if not cli_args:
        return Arguments()
    try:
        return _complete(parse_arguments(cli_args))
    except UnknownArguments as error:
        raise UnknownROSArgsError(str(error)) from None
    except ArgumentError as error:
        raise RCLInvalidROSArgsError(f'Failed to parse ROS arguments: {error}') from None


def override_use(arguments: Arguments) -> OverrideUse | None:
    """Return a watcher that notes which of the arguments' parameters are used; None if there are none."""
    if not arguments.parameters:
        return None
    from goalwire.rules.parameters.unused import OverrideUse

    return OverrideUse(arguments)


def _are_strings(args: object) -> bool:
    return (
        isinstance(args, Sequence) and not isinstance(args, str) and all(isinstance(arg, str) for arg in args)
    )


def _complete(arguments: Arguments) -> Arguments:
    """Read the parameter files; warn if a remap rule has the syntax of ROS 2's first releases."""
    for rule in arguments.deprecated:
        get_logger('rcl').warning(
            f"Found remap rule '{rule}'. This syntax is deprecated. Use '--ros-args --remap {rule}' instead."
        )
    if not arguments.params_files:
        return arguments
    from goalwire.entities.parameters.files import with_files_read

    return with_files_read(arguments)
