"""Runs the programs of this folder: each spins one node until Ctrl-C, SIGTERM or a shutdown."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class UsageError(Exception):
    """The arguments of a program do not fit; the text says why."""


def declare_number(node: Node, name: str, default: float) -> float:
    """Declare a parameter that is a number, and return its value."""
    return node.declare_parameter(name, default).get_parameter_value().double_value


def declare_text(node: Node, name: str, default: str) -> str:
    """Declare a parameter that is a text, and return its value."""
    return node.declare_parameter(name, default).get_parameter_value().string_value


def spin(make_node: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Spin the node that `make_node` returns until Ctrl-C, SIGTERM or a shutdown; returns the exit code.

    `args` are the arguments for rclpy.init. If the node refuses the value of a parameter, one line reports
    it, and the exit code is 1.
    """
    try:
        with rclpy.init(args=None if args is None else list(args)):
            rclpy.spin(make_node())
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0
    except ParameterException as error:
        print(f'the program cannot start: {error}', file=sys.stderr)
        return 1
    return 0


def spin_with_words(
    program: str, usage: str, make_node: Callable[[list[str]], Node], argv: Sequence[str] | None = None
) -> int:
    """Run a program that has arguments of its own, and pass them to `make_node`.

    If it raises UsageError, the reason and the usage are printed, and the exit code is 1.
    """
    arguments = list(sys.argv if argv is None else argv)
    words = rclpy.utilities.remove_ros_args(arguments)[1:]
    if words and words[0] in {'-h', '--help'}:
        print(f'usage: {program} {usage}')
        return 0
    try:
        return spin(lambda: make_node(words), arguments)
    except UsageError as error:
        print(f'{program}: {error}\nusage: {program} {usage}', file=sys.stderr)
        return 1
