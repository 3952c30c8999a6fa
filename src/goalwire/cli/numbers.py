"""Numbers as the command line takes them."""

from __future__ import annotations

from argparse import ArgumentTypeError
from math import isfinite


def positive(text: str) -> float:
    """Read a number above 0."""
    number = float(text)
    if not (isfinite(number) and number > 0):
        raise ArgumentTypeError('give a number above 0')
    return number


def count(text: str) -> int:
    """Read a whole number above 0."""
    number = int(text)
    if number < 1:
        raise ArgumentTypeError('give a whole number above 0')
    return number


def length(text: str) -> int:
    """Read a whole number from 0 on."""
    number = int(text)
    if number < 0:
        raise ArgumentTypeError('give a number from 0 on')
    return number
