"""Checks and conversions of values by type: `launch.utilities.type_utils` of ROS 2, under the same names."""

from __future__ import annotations

import typing
from collections.abc import Iterable
from typing import Any

from goalwire.launching.model import Substitution
from goalwire.launching.values import SCALARS, coerce_to_type, scalar_type


def is_typing_list(data_type: object) -> bool:
    """Return whether a type is `List` or `List[…]`; plain `list` is not."""
    return typing.get_origin(data_type) is list


def is_valid_scalar_type(data_type: object) -> bool:
    """Return whether a type is int, float, bool or str."""
    return data_type in SCALARS


def is_normalized_substitution(value: object) -> bool:
    """Return whether a value is a list that contains only substitutions."""
    return isinstance(value, list) and all(isinstance(item, Substitution) for item in value)


def is_instance_of_valid_type(value: object, *, can_be_str: bool = False) -> bool:
    """Return whether a value is a scalar or a list of scalars of one type.

    With `can_be_str` the list may also have texts in it, since a text may hold a substitution.
    """
    if not isinstance(value, list):
        return type(value) in SCALARS
    kinds = {type(item) for item in value}
    if can_be_str:
        kinds.discard(str)
    return len(kinds) < 2 and kinds <= set(SCALARS)


def is_instance_of(value: object, data_type: object = None, *, can_be_str: bool = False) -> bool:
    """Return whether a value is of a type; an int is not a float. Raises ValueError for unknown types."""
    if data_type is None:
        return is_instance_of_valid_type(value, can_be_str=can_be_str)
    scalar, many = scalar_type(data_type)
    allowed = {scalar, str} if can_be_str else {scalar}
    if many:
        return isinstance(value, list) and all(type(item) in allowed for item in value)
    return type(value) in allowed


def coerce_list(value: list[str], data_type: object = None, can_be_str: bool = False) -> list[Any]:
    """Convert a list of texts to one type. Raises ValueError, and TypeError for anything but such a list."""
    if not _is_list_of_texts(value):
        raise TypeError(f'expected a list of strings, got {value!r:.100}')
    found = [coerce_to_type(item, data_type, can_be_str) for item in value]
    if not is_instance_of_valid_type(found, can_be_str=can_be_str):
        raise ValueError(f'{value!r:.100} is a list of different types')
    return found


def get_typed_value(value: str | list[str], data_type: object = None, *, can_be_str: bool = False) -> Any:
    """Convert a text or a list of texts to a type. Raises ValueError, and TypeError for other objects."""
    if isinstance(value, str):
        return coerce_to_type(value, data_type, can_be_str)
    if not _is_list_of_texts(value):
        raise TypeError(f'expected a string or a list of strings, got {value!r:.100}')
    if data_type is None:
        return coerce_list(value, None, can_be_str)
    scalar, many = scalar_type(data_type)
    if not many:
        raise TypeError(f'{value!r:.100} is a list, and {scalar.__name__} is expected')
    return coerce_list(value, scalar, can_be_str)


def _is_list_of_texts(value: Iterable[object]) -> bool:
    return isinstance(value, list) and all(isinstance(item, str) for item in value)
