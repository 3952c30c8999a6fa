"""Reads numbers of the command line."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError
from math import isfinite


def positive(text: str) -> float:
    """Read a number above 0."""
    number = seconds(text)
    if not number > 0:
        raise ArgumentTypeError(f"'{text}' is not a number above 0")
    return number


def seconds(text: str) -> float:
    """Read a number."""
    try:
        number = float(text)
    except ValueError:
        number = float('nan')
    if not isfinite(number):
        raise ArgumentTypeError(f"'{text}' is not a number")
    return number


def count(text: str) -> int:
    """Read a whole number above 0."""
    return _whole(text, 1, 'above 0')


def length(text: str) -> int:
    """Read a whole number from 0 on."""
    return _whole(text, 0, 'from 0 on')


def port(text: str) -> int:
    """Read a TCP port; 0 stands for any that is free."""
    return _whole(text, 0, 'from 0 to 65535', 65535)


def port_to_name(text: str) -> int:
    """Read a TCP port from 1 on: others connect to it, so it must be fixed."""
    return _whole(text, 1, 'from 1 to 65535', 65535)


def _whole(text: str, least: int, wanted: str, most: float = float('inf')) -> int:
    try:
        number = int(text)
    except ValueError:
        number = least - 1
    if not least <= number <= most:
        raise ArgumentTypeError(f"'{text}' is not a whole number {wanted}")
    return number


def timeout_argument(parser: ArgumentParser, default: float, what: str) -> None:
    """Add `--timeout S`; `what` describes the wait for the help text."""
    parser.add_argument(
        '--timeout', metavar='S', type=positive, default=default, help=f'{what} ({default:g})'
    )
