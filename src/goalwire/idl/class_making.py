"""Makes classes: that of a message from generated source, that of a service or action from its parts."""

from __future__ import annotations

import builtins
import linecache
import os
from array import array
from collections.abc import Mapping
from functools import partial
from types import MappingProxyType

from goalwire.idl.checks import checked, find_checks
from goalwire.idl.class_source import class_source, copied_default
from goalwire.idl.model import ActionDefinition, Definition, MessageDefinition, ServiceDefinition, module_name
from goalwire.idl.runtime import (
    DTYPES,
    TYPECODES,
    arrays_equal,
    message_repr,
    to_array,
    to_fixed,
    unpack_array,
)
from goalwire.idl.slot_types import to_slot_type, type_text


class InterfaceMeta(type):
    """The metaclass of every interface class; rclpy asks for _TYPE_SUPPORT to tell them from others."""

    _TYPE_SUPPORT: str | None = None
    _covered: dict[str, object]  # slots behind values that were set on the class

    def __setattr__(cls, name: str, value: object) -> None:
        """Set a class attribute. A field's name sets the field of every message, as `ros2 param delete` does.

        Messages are read by their slots, so the slot is covered too; setting the property again uncovers it.
        """
        slot = f'_{name}'
        if slot in cls.__dict__.get('__slots__', ()):
            original = cls._covered.setdefault(slot, cls.__dict__[slot])
            super().__setattr__(slot, original if isinstance(value, property) else value)
        super().__setattr__(name, value)

    @classmethod
    def __import_type_support__(cls) -> None:
        """rosidl loads its C code here; there is none."""


class _SlotTypes:
    """SLOT_TYPES, made when first read: most programs never do."""

    def __init__(self, message: MessageDefinition) -> None:
        self._message = message
        self._types: tuple[object, ...] | None = None

    def __get__(self, instance: object, owner: type) -> tuple[object, ...]:
        if self._types is None:
            self._types = tuple(to_slot_type(field.type) for field in self._message.fields)
        return self._types


def make_message_class(message: MessageDefinition, nested: dict[str, type]) -> type:
    """Return a new class for a message; `nested` are the classes of the messages in it, by full name."""
    checks = os.environ.get('ROS_PYTHON_CHECK_FIELDS', '') == '1'
    source, names = class_source(message, nested, checks=checks)
    for field in message.fields:
        cls = nested.get(field.type.base)
        names[f'_check_{field.name}'] = partial(checked, field.name, field.type, cls)
        if field.type.is_number:
            names[f'_dtype_{field.name}'] = DTYPES[TYPECODES[field.type.base]]
    constants = {constant.name: constant.value for constant in message.constants}
    defaults = {
        f'{field.name.upper()}__DEFAULT': copied_default(field)
        for field in message.fields
        if field.default is not None
    }
    names |= {
        '__name__': module_of(message),
        '_Metaclass': _metaclass(message, constants, defaults),
        '_CHECK_FIELDS': checks,
        '_array': array,
        '_arrays_equal': arrays_equal,
        '_bytes': bytes,
        '_checks_asked': find_checks,
        '_isinstance': isinstance,
        '_list': list,
        '_property': builtins.property,
        '_range': range,
        '_to_array': to_array,
        '_to_fixed': to_fixed,
        '_type': builtins.type,
        '_unpack_array': unpack_array,
    }
    cls = _compile(message, source, names)
    _finish(cls, message)
    return cls


def make_holder_class(
    defined: ServiceDefinition | ActionDefinition, kind: str, parts: Mapping[str, object]
) -> type:
    """Return a new class for a service or an action, which only holds the classes of its parts."""

    def refuse(self: object) -> None:
        raise NotImplementedError(f'{kind} classes can not be instantiated')

    namespace = {
        **parts,
        '__init__': refuse,
        '__module__': module_of(defined),
        '__doc__': f'{kind} class {defined.name!r}.',
    }
    return _metaclass(defined)(defined.name, (), namespace)


def module_of(defined: Definition) -> str:
    """Return the name of the module that a class claims to come from, as rosidl has it."""
    return f'{defined.package}.{defined.kind}.{module_name(defined.name.partition("_")[0])}'


def _metaclass(
    defined: Definition,
    constants: Mapping[str, object] = MappingProxyType({}),
    defaults: Mapping[str, object] = MappingProxyType({}),
) -> type[InterfaceMeta]:
    """Make Metaclass_Name: constants and defaults are read-only in the class, and seen in messages."""
    attributes = {**constants, **defaults}
    name = f'Metaclass_{defined.name}'
    namespace: dict[str, object] = {
        '__module__': module_of(defined),
        '__prepare__': staticmethod(lambda *_: dict(attributes)),
        '_TYPE_SUPPORT': defined.full_name,
        f'_{name}__constants': dict(constants),  # rosidl's private name, which `ros2 service echo` reads
        '_covered': {},
    }
    for attribute, value in attributes.items():
        namespace[attribute] = property(partial(_constant, value))
    return type(name, (InterfaceMeta,), namespace)


def _constant(value: object, _cls: type) -> object:
    return value


def _compile(message: MessageDefinition, source: str, names: dict[str, object]) -> type:
    """Run the source; tracebacks show its lines."""
    filename = f'<goalwire {message.full_name}>'
    linecache.cache[filename] = (len(source), None, source.splitlines(keepends=True), filename)
    exec(compile(source, filename, 'exec'), names)  # noqa: S102 - the source is class_source's, from checked names
    cls = names[message.name]
    assert isinstance(cls, type)
    return cls


def _finish(cls: type, message: MessageDefinition) -> None:
    """Add what is the same for every message class."""
    texts = {field.name: type_text(field.type) for field in message.fields}

    def get_fields_and_field_types(_cls: type) -> dict[str, str]:
        return dict(texts)

    attributes = {
        '__doc__': f'Message class {message.name!r}.' + (f'\n\n{message.comment}' if message.comment else ''),
        '__repr__': message_repr,
        '_fields_and_field_types': texts,
        'get_fields_and_field_types': classmethod(get_fields_and_field_types),
        'SLOT_TYPES': _SlotTypes(message),
    }
    for name, value in attributes.items():
        setattr(cls, name, value)
