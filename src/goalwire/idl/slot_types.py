"""Makes rosidl's two descriptions of field types: get_fields_and_field_types (text), SLOT_TYPES (objects)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.idl.model import FieldType, Shape

if TYPE_CHECKING:
    from rosidl_parser.definition import AbstractNestableType, AbstractType

IDL_NAMES = {'bool': 'boolean', 'byte': 'octet', 'char': 'uint8', 'float32': 'float', 'float64': 'double'}
"""The names of primitive types in IDL by their names in .msg files, if the two names differ."""
_MSG_NAMES = {'boolean': 'bool', 'octet': 'byte', 'float': 'float32', 'double': 'float64'}


def type_text(type_: FieldType) -> str:
    """Return a type as text for get_fields_and_field_types: sequence<double, 3>, geometry_msgs/Pose."""
    if type_.is_message:
        package, _, name = type_.base.split('/')
        text = f'{package}/{name}'
    else:
        text = IDL_NAMES.get(type_.base, type_.base)
    if type_.string_capacity:
        text += f'<{type_.string_capacity}>'
    if type_.shape is Shape.ARRAY:
        return f'{text}[{type_.capacity}]'
    if type_.shape is Shape.BOUNDED:
        return f'sequence<{text}, {type_.capacity}>'
    return f'sequence<{text}>' if type_.shape is Shape.UNBOUNDED else text


def to_slot_type(type_: FieldType) -> AbstractType:
    """Return the object that SLOT_TYPES holds for a field of this type."""
    from rosidl_parser import definition as idl

    value = _nestable(type_)
    if type_.shape is Shape.ARRAY:
        return idl.Array(value, type_.capacity)
    if type_.shape is Shape.BOUNDED:
        return idl.BoundedSequence(value, type_.capacity)
    return idl.UnboundedSequence(value) if type_.shape is Shape.UNBOUNDED else value


def _nestable(type_: FieldType) -> AbstractNestableType:
    from rosidl_parser import definition as idl

    if type_.is_message:
        *namespaces, name = type_.base.split('/')
        return idl.NamespacedType(namespaces, name)
    if type_.is_string:
        wide = type_.base == 'wstring'
        if type_.string_capacity:
            return (idl.BoundedWString if wide else idl.BoundedString)(type_.string_capacity)
        return idl.UnboundedWString() if wide else idl.UnboundedString()
    return idl.BasicType(IDL_NAMES.get(type_.base, type_.base))


def from_slot_type(slot: object) -> FieldType:
    """Return the type that an object in SLOT_TYPES describes; the object may be of any rosidl_parser."""
    value: Any = getattr(slot, 'value_type', slot)
    if hasattr(value, 'namespaces'):
        base, string_capacity = '/'.join((*value.namespaces, value.name)), 0
    elif hasattr(value, 'typename'):
        base, string_capacity = _MSG_NAMES.get(value.typename, value.typename), 0
    else:
        base = 'wstring' if type(value).__name__.endswith('WString') else 'string'
        string_capacity = int(getattr(value, 'maximum_size', 0))
    if value is slot:
        return FieldType(base, string_capacity=string_capacity)
    for attribute, shape in (('size', Shape.ARRAY), ('maximum_size', Shape.BOUNDED)):
        if hasattr(slot, attribute):
            return FieldType(base, shape, getattr(slot, attribute), string_capacity)
    return FieldType(base, Shape.UNBOUNDED, 0, string_capacity)
