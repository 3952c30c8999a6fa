"""rosidl_runtime_py.set_message: fills a message from a dictionary, for example from YAML."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rosidl_parser.definition import AbstractNestedType, NamespacedType

from rosidl_runtime_py.convert import get_message_slot_types
from rosidl_runtime_py.import_message import import_message_from_namespaced_type

__all__ = ['set_message_fields']

_HEADER = 'std_msgs.msg._header.Header'
_TIME = 'builtin_interfaces.msg._time.Time'


def set_message_fields(
    msg: Any, values: Mapping[str, object], expand_header_auto: bool = False, expand_time_now: bool = False
) -> list[Callable[[object], None]]:
    """Set the fields that `values` names, each value converted to its field's type if necessary.

    With `expand_header_auto` a header may be 'auto', with `expand_time_now` a time may be 'now'. For each of
    these, a function is returned: call it with a builtin_interfaces/Time before each publication, to set the
    time.

    Raises TypeError if a value is not a dictionary, AttributeError for an unknown field, ValueError for a
    text that is not a number.
    """
    filling = _Filling(expand_header_auto, expand_time_now)
    filling.fill(msg, values)
    return filling.stamp_setters


class _Filling:
    def __init__(self, header_auto: bool, time_now: bool) -> None:
        self.header_auto = header_auto
        self.time_now = time_now
        self.stamp_setters: list[Callable[[object], None]] = []

    def fill(self, msg: Any, values: object) -> None:
        if not isinstance(values, Mapping):
            raise TypeError(
                f"Value '{values}' is expected to be a dictionary but is a {type(values).__name__}"
            )
        for name, value in values.items():
            old = getattr(msg, name)
            setter = self._stamp_setter(msg, name, old, value)
            if setter is None:
                setattr(msg, name, self._convert(get_message_slot_types(msg)[name], old, value))
            else:
                self.stamp_setters.append(setter)

    def _stamp_setter(
        self, msg: object, name: str, old: object, value: object
    ) -> Callable[[object], None] | None:
        kind = f'{type(old).__module__}.{type(old).__name__}'
        if self.header_auto and kind == _HEADER and value == 'auto':
            return partial(setattr, old, 'stamp')
        if self.time_now and kind == _TIME and value == 'now':
            return partial(setattr, msg, name)
        return None

    def _convert(self, slot: object, old: Any, value: Any) -> object:
        """Return the value converted for a field of type `slot`, whose current value is `old`."""
        if isinstance(slot, AbstractNestedType) and isinstance(slot.value_type, NamespacedType):
            cls = import_message_from_namespaced_type(slot.value_type)
            return [self._message(cls, item) for item in value]
        if isinstance(slot, NamespacedType):
            return self._message(type(old), value)
        if isinstance(old, array):
            return array(old.typecode, value)
        if isinstance(old, bytes):
            return bytes([value]) if isinstance(value, int) else bytes(value)
        if hasattr(old, 'dtype'):
            import numpy as np

            return np.array(value, dtype=old.dtype)
        return type(old)(value)

    def _message(self, cls: type, value: object) -> object:
        if isinstance(value, cls):
            return value
        message = cls()
        self.fill(message, value)
        return message
