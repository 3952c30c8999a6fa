"""Registers functions that transform and convert objects, by the objects' type.

Packages such as tf2_geometry_msgs register their types in this module's tables.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, ClassVar, TypeAlias, TypeVar

from geometry_msgs.msg import TransformStamped

from goalwire.errors import TypeException

__all__ = ['ConvertRegistration', 'TransformRegistration', 'TypeException', 'convert']

T = TypeVar('T')
Transformer: TypeAlias = Callable[[Any, TransformStamped], Any]
Converter: TypeAlias = Callable[[Any], Any]


class TransformRegistration:
    """The functions that transform objects, by the objects' type; the whole process shares one table."""

    _transformers: ClassVar[dict[type, Transformer]] = {}

    def print_me(self) -> None:
        """Print the table."""
        print(self._transformers)  # noqa: T201

    def add(self, key: type, callback: Transformer) -> None:
        """Register `callback(object, transform)`, which transforms objects of a type."""
        self._transformers[key] = callback

    def get(self, key: type) -> Transformer:
        """Return the function that transforms objects of a type; raises TypeException if there is none."""
        return _find_registered(self._transformers, key)


class ConvertRegistration:
    """The functions that convert objects, by the objects' type: to messages, from messages, and directly."""

    _to_msg: ClassVar[dict[type, Converter]] = {}
    _from_msg: ClassVar[dict[type, Converter]] = {}
    _direct: ClassVar[dict[tuple[type, type], Converter]] = {}

    def add_from_msg(self, key: type, callback: Converter) -> None:
        """Register `callback(message)`, which makes objects of a type from messages."""
        self._from_msg[key] = callback

    def add_to_msg(self, key: type, callback: Converter) -> None:
        """Register `callback(object)`, which makes messages from objects of a type."""
        self._to_msg[key] = callback

    def add_convert(self, key: tuple[type, type], callback: Converter) -> None:
        """Register `callback(object)`, which converts objects directly; `key` is (type from, type to)."""
        self._direct[key] = callback

    def get_from_msg(self, key: type) -> Converter:
        """Return the function that makes objects of a type from messages; TypeException if there is none."""
        return _find_registered(self._from_msg, key)

    def get_to_msg(self, key: type) -> Converter:
        """Return the function that makes messages from objects of a type; TypeException if there is none."""
        return _find_registered(self._to_msg, key)

    def get_convert(self, key: tuple[type, type]) -> Converter:
        """Return the function that converts one type directly to another; TypeException if there is none."""
        return _find_registered(self._direct, key)


def convert(a: Any, b_type: type[T]) -> T:
    """Return `a` converted to another type: directly, or by a message; a copy if it has this type already.

    Raises TypeException if no conversion is registered.
    """
    registration = ConvertRegistration()
    try:
        direct = registration.get_convert((type(a), b_type))
    except TypeException:
        if type(a) is b_type:
            return deepcopy(a)
        message = registration.get_to_msg(type(a))(a)
        return registration.get_from_msg(b_type)(message)  # type: ignore[no-any-return]
    return direct(a)  # type: ignore[no-any-return]


KeyT = TypeVar('KeyT')
ValueT = TypeVar('ValueT')


def _find_registered(table: dict[KeyT, ValueT], key: KeyT) -> ValueT:
    if key not in table:
        raise TypeException(
            f'Type {key} is not loaded or supported: import the package that registers it, such as '
            'tf2_geometry_msgs'
        )
    return table[key]
