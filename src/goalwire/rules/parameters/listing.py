"""Finds the names that answer a request to list parameters (rcl_interfaces/srv/ListParameters)."""

from __future__ import annotations

from collections.abc import Iterable

SEPARATOR = '.'
"""The separator of the parts of a parameter's name."""

RECURSIVE = 0
"""The depth that means all depths."""


def list_names(names: Iterable[str], prefixes: list[str], depth: int) -> tuple[list[str], list[str]]:
    """Return the names at or below one of the prefixes, and the prefixes of these names.

    Without prefixes it returns all names. A name may have up to `depth` parts below its prefix. Raises
    TypeError and ValueError as rclpy does.
    """
    _check(prefixes, depth)
    found = [name for name in names if _is_listed(name, prefixes, depth)]
    # Each prefix is listed once, in the order of appearance.
    heads = dict.fromkeys(name.rpartition(SEPARATOR)[0] for name in found if SEPARATOR in name)
    return found, list(heads)


def _check(prefixes: object, depth: object) -> None:
    if not isinstance(prefixes, list):
        raise TypeError('The prefixes argument must be a list')
    if not all(isinstance(prefix, str) for prefix in prefixes):
        raise TypeError('All prefixes must be instances of type str')
    if not isinstance(depth, int):
        raise TypeError('The depth must be instance of type int')
    if depth < 0:
        raise ValueError('The depth must be greater than or equal to zero')


def _is_listed(name: str, prefixes: list[str], depth: int) -> bool:
    if not prefixes:
        return depth == RECURSIVE or name.count(SEPARATOR) < depth
    return any(name == prefix or _is_below(name, f'{prefix}{SEPARATOR}', depth) for prefix in prefixes)


def _is_below(name: str, start: str, depth: int) -> bool:
    return name.startswith(start) and (depth == RECURSIVE or name[len(start) :].count(SEPARATOR) < depth)
