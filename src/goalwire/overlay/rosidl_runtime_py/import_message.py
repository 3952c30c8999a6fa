"""rosidl_runtime_py.import_message: finds the message class for a type of rosidl_parser."""

from __future__ import annotations

from importlib import import_module

from rosidl_parser.definition import NamespacedType

__all__ = ['import_message_from_namespaced_type']


def import_message_from_namespaced_type(message_type: NamespacedType) -> type:
    """Return the message class for a type such as NamespacedType(['std_msgs', 'msg'], 'String').

    Raises ModuleNotFoundError for an unknown package, AttributeError for an unknown type.
    """
    found: type = getattr(import_module('.'.join(message_type.namespaces)), message_type.name)
    return found
