"""The definition behind any interface class: goalwire's own, or one that a real rosidl generated."""

from __future__ import annotations

from typing import Protocol, cast

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
from goalwire.idl.type_names import type_name


class MessageClass(Protocol):
    """The part of a generated message class that tells its fields."""

    SLOT_TYPES: tuple[object, ...]

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class _ServiceClass(Protocol):
    Request: type
    Response: type


class _ActionClass(Protocol):
    Goal: type
    Result: type
    Feedback: type


def definition_of(cls: type) -> Definition:
    """Return the definition of a message, service or action class; else UnknownInterfaceError."""
    own = classes.own_definition(cls)
    if own is not None:
        return own
    type_name(cls)  # raises for what is no interface class
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


def _foreign_message(cls: type) -> MessageDefinition:
    message = cast('MessageClass', cls)
    package, kind, name = type_name(cls).split('/')
    fields = zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True)
    return MessageDefinition(
        package,
        kind,
        name,
        tuple(Field(field, from_slot_type(slot)) for field, slot in fields),
        source=cls.__module__,
    )


def _foreign_service(cls: type) -> ServiceDefinition:
    service = cast('_ServiceClass', cls)
    return derived_types.service(_foreign_message(service.Request), _foreign_message(service.Response))


def _foreign_action(cls: type) -> ActionDefinition:
    action = cast('_ActionClass', cls)
    return derived_types.action(
        *(_foreign_message(part) for part in (action.Goal, action.Result, action.Feedback))
    )
