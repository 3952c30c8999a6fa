"""Python classes for messages, services and actions, as rosidl generates them: built once, at the first use.

Two threads may build the same class at the same time. Then both get the class of the thread that finishes
first, so no lock is held while nested packages are imported.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from goalwire.errors import InterfaceSyntaxError, UnknownInterfaceError
from goalwire.idl import extent, registry
from goalwire.idl.class_making import make_holder_class, make_message_class, module_of
from goalwire.idl.derived_types import CANCEL_SERVICE, STATUS_MESSAGE
from goalwire.idl.model import ActionDefinition, Definition, MessageDefinition, ServiceDefinition, module_name

_classes: dict[str, type] = {}
_extents: dict[type, extent.Extent] = {}
_KEPT = '__definition__'
"""The class attribute with a class's definition; no field or constant can have this name."""


class _Part:
    """A class attribute such as Request: the class is built at the first read, and replaces this object."""

    def __init__(self, full_name: str) -> None:
        self._full_name = full_name

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, instance: object, owner: type) -> type:
        part = find_class(self._full_name)
        setattr(owner, self._name, part)
        return part


def find_made_classes(name: str) -> list[type]:
    """Return the message classes with this name, of any package, that have been made so far."""
    return [cls for cls in list(_classes.values()) if cls.__name__ == name]


def message_class(full_name: str) -> type:
    """Return the class of 'pkg/msg/Name' or of a message derived from a service or action.

    Raises UnknownInterfaceError, or InterfaceSyntaxError for a malformed definition, nested ones included.
    """
    message = registry.message_definition(full_name)
    return _classes.get(full_name) or _build_message(message)


def service_class(full_name: str) -> type:
    """Return the class of 'pkg/srv/Name', or of a service of an action ('pkg/action/Name_SendGoal')."""
    service = registry.definition(full_name)
    if not isinstance(service, ServiceDefinition):
        raise UnknownInterfaceError(f'{full_name} is not a service')
    return _classes.get(full_name) or _build_service(service)


def action_class(full_name: str) -> type:
    """Return the class of 'pkg/action/Name'."""
    action = registry.definition(full_name)
    if not isinstance(action, ActionDefinition):
        raise UnknownInterfaceError(f'{full_name} is not an action')
    return _classes.get(full_name) or _build_action(action)


def find_class(full_name: str, _inside: tuple[str, ...] = ()) -> type:
    """Return the class that `from pkg.msg import Name` gives: a real ROS 2's if that is importable."""
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
    module = f'{package}.{kind}.{module_name(name.partition("_")[0])}'  # this module has derived types, too
    try:
        found = getattr(import_module(module), name)
    except (ImportError, AttributeError):
        raise UnknownInterfaceError(
            f'{package}/{kind}/{name}: the installed {package} has no such type'
        ) from None
    assert isinstance(found, type)
    return found


def foreign_module(package: str, kind: str) -> ModuleType | None:
    """Return the module 'pkg.msg' of a real ROS 2; None if no such module is importable here."""
    try:
        module = import_module(f'{package}.{kind}')
    except ImportError:
        return None  # the import hook is not installed, or the package has no types of this kind
    return module if getattr(module, '__file__', None) else None


def own_definition(cls: type) -> Definition | None:
    """Return the definition of a class that this module made; None for any other class."""
    kept: Definition | None = getattr(cls, '__dict__', {}).get(_KEPT)
    return kept


def _build_message(message: MessageDefinition, inside: tuple[str, ...] = ()) -> type:
    nested = _make_nested_classes(message, inside)
    sizes = {name: _extents[cls] for name, cls in nested.items() if cls in _extents}
    size = extent.extent_of(message, sizes)
    cls = make_message_class(message, nested)
    _extents[cls] = size
    return _publish(message, cls)


def _make_nested_classes(message: MessageDefinition, inside: tuple[str, ...]) -> dict[str, type]:
    """Return the classes of a message's nested messages; `inside` has the names of its enclosing messages."""
    if message.full_name in inside:
        circle = ' -> '.join((*inside[inside.index(message.full_name) :], message.full_name))
        raise InterfaceSyntaxError(message.source, 0, 0, f'a message cannot contain itself: {circle}')
    found = {}
    for field in message.fields:
        if field.type.is_message and field.type.base not in found:
            if len(inside) >= 2 * extent.MAX_DEPTH:  # a rough limit: exact levels are counted later
                raise extent.too_deep(message, field)
            try:
                found[field.type.base] = find_class(field.type.base, (*inside, message.full_name))
            except UnknownInterfaceError as error:
                problem = f'field {field.name}: {error}'
                raise InterfaceSyntaxError(message.source, field.line, 1, problem) from None
    return found


def _build_service(service: ServiceDefinition) -> type:
    parts = {
        'Request': _Part(service.request.full_name),
        'Response': _Part(service.response.full_name),
        'Event': _Part(service.event.full_name),
    }
    return _publish(service, make_holder_class(service, 'Service', parts))


def _build_action(action: ActionDefinition) -> type:
    impl = {
        'SendGoalService': _Part(action.send_goal.full_name),
        'GetResultService': _Part(action.get_result.full_name),
        'FeedbackMessage': _Part(action.feedback_message.full_name),
        'CancelGoalService': _Part(CANCEL_SERVICE),
        'GoalStatusMessage': _Part(STATUS_MESSAGE),
    }
    names = {'__module__': module_of(action), '__qualname__': f'{action.name}.Impl'}
    parts = {
        'Goal': _Part(action.goal.full_name),
        'Result': _Part(action.result.full_name),
        'Feedback': _Part(action.feedback.full_name),
        'Impl': type('Impl', (), {**impl, **names}),
    }
    return _publish(action, make_holder_class(action, 'Action', parts))


def _publish(defined: Definition, cls: type) -> type:
    winner = _classes.setdefault(defined.full_name, cls)
    setattr(winner, _KEPT, defined)
    return winner
