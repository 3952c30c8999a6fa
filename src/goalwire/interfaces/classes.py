"""Python classes for messages, services and actions, as rosidl generates them: built when first asked for,
once.

Two threads may build the same class at the same time; the first to finish wins and both get its class, so
no lock is needed while nested packages are imported.
"""

from __future__ import annotations

import builtins
import linecache
import os
from array import array
from collections.abc import Mapping
from functools import partial
from importlib import import_module
from types import ModuleType

from goalwire.errors import InterfaceSyntaxError, UnknownInterfaceError
from goalwire.interfaces import registry
from goalwire.interfaces.checks import checked, reject_unknown
from goalwire.interfaces.class_source import class_source, copied_default
from goalwire.interfaces.implicit import CANCEL_SERVICE, STATUS_MESSAGE
from goalwire.interfaces.model import ActionDefinition, Definition, MessageDefinition, ServiceDefinition
from goalwire.interfaces.naming import module_name
from goalwire.interfaces.runtime import (
    DTYPES,
    TYPECODES,
    arrays_equal,
    message_repr,
    to_array,
    to_ndarray,
)
from goalwire.interfaces.slot_types import to_slot_type, type_text

_classes: dict[str, type] = {}
_names: dict[type, str] = {}


class InterfaceMeta(type):
    """The metaclass of every interface class; rclpy asks for _TYPE_SUPPORT to tell them from others."""

    _TYPE_SUPPORT: str | None = None

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


class _Part:
    """A class attribute such as Request: the class is built when first read and then replaces this."""

    def __init__(self, full_name: str) -> None:
        self._full_name = full_name

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, instance: object, owner: type) -> type:
        part = find_class(self._full_name)
        setattr(owner, self._name, part)
        return part


def message_class(full_name: str) -> type:
    """Return the class of 'pkg/msg/Name' or of a message derived from a service or action.

    Raises UnknownInterfaceError, or InterfaceSyntaxError where this or a nested definition is malformed.
    """
    message = registry.message_definition(full_name)
    return _classes.get(full_name) or _build_message(message)


def service_class(full_name: str) -> type:
    """Return the class of 'pkg/srv/Name', or of a service of an action ('pkg/action/Name_SendGoal')."""
    service = registry.definition(full_name)
    if not isinstance(service, ServiceDefinition):
        raise UnknownInterfaceError(f'{full_name} is no service')
    return _classes.get(full_name) or _build_service(service)


def action_class(full_name: str) -> type:
    """Return the class of 'pkg/action/Name'."""
    action = registry.definition(full_name)
    if not isinstance(action, ActionDefinition):
        raise UnknownInterfaceError(f'{full_name} is no action')
    return _classes.get(full_name) or _build_action(action)


def find_class(full_name: str, _inside: tuple[str, ...] = ()) -> type:
    """Return the class that `from pkg.msg import Name` gives: a real ROS 2 package's where there is one."""
    found = _classes.get(full_name)
    if found is not None:
        return found
    package, kind, name = registry.split_name(full_name)
    module = foreign_module(package, kind)
    if module is not None:
        return _foreign_class(package, kind, name)
    defined = registry.definition(full_name)
    if isinstance(defined, MessageDefinition):
        return _build_message(defined, _inside)
    return service_class(full_name) if isinstance(defined, ServiceDefinition) else action_class(full_name)


def _foreign_class(package: str, kind: str, name: str) -> type:
    module = f'{package}.{kind}.{module_name(name.partition("_")[0])}'  # holds the derived types too
    try:
        found = getattr(import_module(module), name)
    except (ImportError, AttributeError):
        raise UnknownInterfaceError(
            f'{package}/{kind}/{name}: the installed {package} has no such type'
        ) from None
    assert isinstance(found, type)
    return found


def foreign_module(package: str, kind: str) -> ModuleType | None:
    """Return the module 'pkg.msg' of a real ROS 2 that is importable here, None where there is none."""
    try:
        module = import_module(f'{package}.{kind}')
    except ImportError:
        return None  # the import hook is not installed, or the package has no such kind
    return module if getattr(module, '__file__', None) else None


def name_of(cls: type) -> str | None:
    """Return the full name of a class that this module made, None for any other."""
    return _names.get(cls)


def _module(defined: Definition) -> str:
    return f'{defined.package}.{defined.kind}.{module_name(defined.name.partition("_")[0])}'


def _metaclass(defined: Definition, attributes: Mapping[str, object]) -> type[InterfaceMeta]:
    """Make Metaclass_Name: `attributes` become read-only properties of the class and visible in instances."""
    namespace: dict[str, object] = {
        '__module__': _module(defined),
        '__prepare__': staticmethod(lambda *_: dict(attributes)),
        '_TYPE_SUPPORT': defined.full_name,
    }
    for name, value in attributes.items():
        namespace[name] = property(partial(_constant, value))
    return type(f'Metaclass_{defined.name}', (InterfaceMeta,), namespace)


def _constant(value: object, _cls: type) -> object:
    return value


def _build_service(service: ServiceDefinition) -> type:
    parts = {
        'Request': _Part(service.request.full_name),
        'Response': _Part(service.response.full_name),
        'Event': _Part(service.event.full_name),
    }
    return _build_holder(service, 'Service', parts)


def _build_action(action: ActionDefinition) -> type:
    impl = {
        'SendGoalService': _Part(action.send_goal.full_name),
        'GetResultService': _Part(action.get_result.full_name),
        'FeedbackMessage': _Part(action.feedback_message.full_name),
        'CancelGoalService': _Part(CANCEL_SERVICE),
        'GoalStatusMessage': _Part(STATUS_MESSAGE),
    }
    names = {'__module__': _module(action), '__qualname__': f'{action.name}.Impl'}
    parts = {
        'Goal': _Part(action.goal.full_name),
        'Result': _Part(action.result.full_name),
        'Feedback': _Part(action.feedback.full_name),
        'Impl': type('Impl', (), {**impl, **names}),
    }
    return _build_holder(action, 'Action', parts)


def _build_holder(
    defined: ServiceDefinition | ActionDefinition, kind: str, parts: Mapping[str, object]
) -> type:
    """Make the class of a service or an action, which only holds the classes of its parts."""

    def refuse(self: object) -> None:
        raise NotImplementedError(f'{kind} classes can not be instantiated')

    namespace = {
        **parts,
        '__init__': refuse,
        '__module__': _module(defined),
        '__doc__': f'{kind} class {defined.name!r}.',
    }
    return _publish(defined, _metaclass(defined, {})(defined.name, (), namespace))


def _nested_classes(message: MessageDefinition, inside: tuple[str, ...]) -> dict[str, type]:
    """Return the classes of the messages in a message; `inside` names those around it."""
    if message.full_name in inside:
        circle = ' -> '.join((*inside[inside.index(message.full_name) :], message.full_name))
        raise InterfaceSyntaxError(message.source, 0, 0, f'a message cannot contain itself: {circle}')
    found = {}
    for field in message.fields:
        if field.type.is_message:
            try:
                found[field.type.base] = find_class(field.type.base, (*inside, message.full_name))
            except UnknownInterfaceError as error:
                problem = f'field {field.name}: {error}'
                raise InterfaceSyntaxError(message.source, field.line, 1, problem) from None
    return found


def _build_message(message: MessageDefinition, inside: tuple[str, ...] = ()) -> type:
    nested = _nested_classes(message, inside)
    source, names = class_source(message, nested)
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
        '__name__': _module(message),
        '_Metaclass': _metaclass(message, {**constants, **defaults}),
        '_CHECK_FIELDS': os.environ.get('ROS_PYTHON_CHECK_FIELDS', '') == '1',
        '_array': array,
        '_arrays_equal': arrays_equal,
        '_isinstance': isinstance,
        '_list': list,
        '_property': builtins.property,
        '_range': range,
        '_reject_unknown': reject_unknown,
        '_to_array': to_array,
        '_to_ndarray': to_ndarray,
    }
    cls = _compile(message, source, names)
    _finish(cls, message)
    return _publish(message, cls)


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


def _publish(defined: Definition, cls: type) -> type:
    winner = _classes.setdefault(defined.full_name, cls)
    _names[winner] = defined.full_name
    return winner
