"""Makes classes: those of messages from generated source, those of services and actions from their parts."""

from __future__ import annotations

import builtins
import os
from array import array
from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Protocol

from goalwire.idl.checks import checked, find_checks, python_type
from goalwire.idl.class_source import class_source, copy_default
from goalwire.idl.generated_code import run_source
from goalwire.idl.model import (
    ActionDefinition,
    Definition,
    Field,
    MessageDefinition,
    ServiceDefinition,
    Shape,
    module_name,
)
from goalwire.idl.runtime import (
    DTYPES,
    TYPECODES,
    arrays_equal,
    message_repr,
    reduce_message,
    to_array,
    to_fixed,
    unpack_array,
)
from goalwire.idl.slot_types import to_slot_type, type_text

_PICTURES = frozenset({'sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage'})


class InterfaceMeta(type):
    """The metaclass of all interface classes; rclpy recognises interface classes by _TYPE_SUPPORT."""

    _TYPE_SUPPORT: str | None = None
    _covered: dict[str, object]  # original slots of fields that were set on the class

    def __setattr__(cls, name: str, value: object) -> None:
        """Set a class attribute. A field's name sets the field of all messages; `ros2 param delete` needs it.

        Messages are read by their slots, so the value also covers the slot; setting the field's property
        again uncovers the slot.
        """
        slot = f'_{name}'
        if slot in cls.__dict__.get('__slots__', ()):
            original = cls._covered.setdefault(slot, cls.__dict__[slot])
            super().__setattr__(slot, original if isinstance(value, property) else value)
        super().__setattr__(name, value)

    @classmethod
    def __import_type_support__(cls) -> None:
        """Do nothing: rosidl's metaclass loads C code here, but goalwire has none."""


class _Printer(Protocol):
    """As IPython's."""

    def text(self, text: str) -> None: ...


class _Made:
    """A class attribute that is computed when it is first read, since most programs never read it."""

    def __init__(self, make: Callable[[], object]) -> None:
        self._make = make
        self._made: object = None

    def __get__(self, instance: object, owner: type) -> object:
        if self._made is None:
            self._made = self._make()
        return self._made


class _Signature(_Made):
    """The signature of a message class. When first read, it is also set on the class's constructor."""

    def __get__(self, instance: object, owner: type) -> object:
        made = super().__get__(instance, owner)
        if isinstance(instance, type):  # now, since help() reads the class before its methods
            vars(instance)['__init__'].__signature__ = made
        return made


class _Documentation(_Made):
    """The docstring of a class and its instances, stored in the metaclass, where pydoc also reads it."""

    def __get__(self, instance: object, owner: type) -> object:
        return self if instance is None else super().__get__(instance, owner)

    def __set__(self, _owner: object, text: object) -> None:
        self._made = text


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
        f'{field.name.upper()}__DEFAULT': copy_default(field)
        for field in message.fields
        if field.default is not None
    }
    metaclass = _metaclass(message, constants, defaults)
    names |= {
        '__name__': module_of(message),
        '_Metaclass': metaclass,
        '_documentation': vars(metaclass)['__doc__'],
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
    _finish(cls, message, nested)
    return cls


def make_holder_class(
    defined: ServiceDefinition | ActionDefinition, kind: str, parts: Mapping[str, object]
) -> type:
    """Return a new class for a service or an action; it only has the classes of its parts as attributes."""

    def refuse(self: object) -> None:
        name, part = type(self).__name__, 'Request' if kind == 'Service' else 'Goal'
        raise NotImplementedError(
            f'{kind} classes can not be instantiated: {name} only holds its parts; write {name}.{part}()'
        )

    namespace = {
        **parts,
        '__init__': refuse,
        '__module__': module_of(defined),
    }
    metaclass = _metaclass(defined)
    return metaclass(defined.name, (), {**namespace, '__doc__': vars(metaclass)['__doc__']})


def module_of(defined: Definition) -> str:
    """Return the name of the module that would contain rosidl's class for this definition."""
    return f'{defined.package}.{defined.kind}.{module_name(defined.name.partition("_")[0])}'


def _metaclass(
    defined: Definition,
    constants: Mapping[str, object] = MappingProxyType({}),
    defaults: Mapping[str, object] = MappingProxyType({}),
) -> type[InterfaceMeta]:
    """Make Metaclass_Name: constants and defaults are read-only in the class, and visible in messages."""
    attributes = {**constants, **defaults}
    name = f'Metaclass_{defined.name}'
    namespace: dict[str, object] = {
        '__module__': module_of(defined),
        '__doc__': _Documentation(partial(_document, defined)),
        '__prepare__': staticmethod(lambda *_: dict(attributes)),
        '_TYPE_SUPPORT': defined.full_name,
        f'_{name}__constants': dict(constants),  # rosidl's private name, which `ros2 service echo` reads
        '_covered': {},
    }
    if isinstance(defined, MessageDefinition):
        namespace['__signature__'] = _Signature(
            partial(_sign, defined)
        )  # in the metaclass, so that help() does not list it
    for attribute, value in attributes.items():
        namespace[attribute] = property(partial(_constant, value))
    return type(name, (InterfaceMeta,), namespace)


def _constant(value: object, _cls: type) -> object:
    return value


def _compile(message: MessageDefinition, source: str, names: dict[str, object]) -> type:
    run_source(source, names, message.full_name)
    cls = names[message.name]
    assert isinstance(cls, type)
    return cls


def _finish(cls: type, message: MessageDefinition, nested: Mapping[str, type]) -> None:
    """Add the attributes and methods that every message class has."""
    texts = {field.name: type_text(field.type) for field in message.fields}

    def get_fields_and_field_types(_cls: type) -> dict[str, str]:
        return dict(texts)

    attributes = {
        '__reduce_ex__': reduce_message,
        '__repr__': message_repr,
        '_fields_and_field_types': texts,
        '_repr_pretty_': _print_shortened,
        'get_fields_and_field_types': classmethod(get_fields_and_field_types),
        'SLOT_TYPES': _Made(partial(_slot_types, message)),
    }
    if message.full_name in _PICTURES:
        attributes |= {'_repr_png_': _show_png, '_repr_jpeg_': _show_jpeg}
    for name, value in attributes.items():
        setattr(cls, name, value)
    for field in message.fields:
        _describe(vars(cls)[field.name], field, nested)


def _describe(attribute: property, field: Field, nested: Mapping[str, type]) -> None:
    """Set a field's docstring from its comment, and its type, by which IPython completes nested fields."""
    if field.comment:
        attribute.__doc__ = f'Message field {field.name!r}: {field.comment}'
    if field.type.shape is Shape.SINGLE and attribute.fget is not None:
        attribute.fget.__annotations__['return'] = python_type(field.type, nested.get(field.type.base))


def _slot_types(message: MessageDefinition) -> tuple[object, ...]:
    return tuple(to_slot_type(field.type) for field in message.fields)


def _document(defined: Definition) -> str:
    from goalwire.idl.message_display import document

    return document(defined)


def _sign(message: MessageDefinition) -> object:
    from goalwire.idl.message_display import signature

    return signature(message)


# IPython calls these functions to show a message.


def _print_shortened(message: object, printer: _Printer, cycle: bool) -> None:  # noqa: ARG001 - IPython's
    from goalwire.idl.message_display import shorten

    printer.text(shorten(message))


def _show_png(message: object) -> bytes | None:
    from goalwire.idl.message_display import picture

    return picture(message, 'image/png')


def _show_jpeg(message: object) -> bytes | None:
    from goalwire.idl.message_display import picture

    return picture(message, 'image/jpeg')
