"""Maps classes to names and definitions, and names to classes; also for classes of a real rosidl."""

from __future__ import annotations

from typing import Any

from goalwire.errors import UnknownInterfaceError
from goalwire.idl import classes, derived_types, registry
from goalwire.idl.model import (
    ActionDefinition,
    Definition,
    Field,
    MessageDefinition,
    ServiceDefinition,
)
from goalwire.idl.slot_types import from_slot_type


def type_name(cls: type) -> str:
    """Return 'std_msgs/msg/String' for the class String; raises UnknownInterfaceError for other classes."""
    own = classes.own_definition(cls)
    if own is not None:
        return own.full_name
    package, _, rest = getattr(cls, '__module__', '').partition('.')
    kind = rest.partition('.')[0]
    if kind not in ('msg', 'srv', 'action') or not hasattr(type(cls), '_TYPE_SUPPORT'):
        raise UnknownInterfaceError(f'{cls!r} is not a message, service or action class')
    return f'{package}/{kind}/{cls.__name__}'


def get_message(name: str) -> type:
    """Return the class of 'std_msgs/msg/String'."""
    return _class_of_kind(name, 'msg')


def get_service(name: str) -> type:
    """Return the class of 'std_srvs/srv/SetBool'."""
    return _class_of_kind(name, 'srv')


def get_action(name: str) -> type:
    """Return the class of 'example_interfaces/action/Fibonacci'."""
    return _class_of_kind(name, 'action')


def get_interface(name: str) -> type:
    """Return the class for any full name of a message, service or action, derived types included."""
    return classes.find_class(name)


def _class_of_kind(name: str, kind: str) -> type:
    package, own, type_ = registry.split_name(name)
    if own != kind:
        raise UnknownInterfaceError(f'{name} is of kind {own}, not {kind}')
    return classes.find_class(f'{package}/{own}/{type_}')


def definition_of(cls: type) -> Definition:
    """Return the definition of a message, service or action class, else raise UnknownInterfaceError."""
    own = classes.own_definition(cls)
    if own is not None:
        return own
    type_name(cls)  # raises an error for other classes
    if hasattr(cls, 'get_fields_and_field_types'):
        return _foreign_message(cls)
    return _foreign_service(cls) if hasattr(cls, 'Request') else _foreign_action(cls)


def definition_by_name(full_name: str) -> Definition:
    """Return the definition of the class that `from pkg.msg import Name` gives."""
    package, kind, name = registry.split_name(full_name)
    if classes.foreign_module(package, kind) is None:
        return registry.definition(full_name)
    whole = definition_of(classes.find_class(f'{package}/{kind}/{name.partition("_")[0]}'))
    for part in registry.with_derived(whole):
        if part.full_name == full_name:
            return part
    raise UnknownInterfaceError(f'{full_name}: {whole.full_name} has no part of this name')


def _foreign_message(message: Any) -> MessageDefinition:
    package, kind, name = type_name(message).split('/')
    fields = zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True)
    return MessageDefinition(
        package,
        kind,
        name,
        tuple(Field(field, from_slot_type(slot)) for field, slot in fields),
        source=message.__module__,
    )


def _foreign_service(service: Any) -> ServiceDefinition:
    return derived_types.service(_foreign_message(service.Request), _foreign_message(service.Response))


def _foreign_action(action: Any) -> ActionDefinition:
    return derived_types.action(
        *(_foreign_message(part) for part in (action.Goal, action.Result, action.Feedback))
    )
