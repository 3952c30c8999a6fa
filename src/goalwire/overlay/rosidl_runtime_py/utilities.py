"""rosidl_runtime_py.utilities: finds message, service and action classes by name."""

from __future__ import annotations

from importlib import import_module

from rosidl_parser.definition import NamespacedType

from goalwire.errors import InterfaceError
from goalwire.idl import rosidl_compat
from rosidl_runtime_py.import_message import import_message_from_namespaced_type

__all__ = [
    'get_action',
    'get_action_namespaced_type',
    'get_interface',
    'get_message',
    'get_message_namespaced_type',
    'get_namespaced_type',
    'get_service',
    'get_service_namespaced_type',
    'import_message_from_namespaced_type',
    'is_action',
    'is_message',
    'is_service',
]


def get_interface(identifier: str) -> type:
    """Return the class with a full name such as std_msgs/msg/String or std_srvs/srv/SetBool.

    Raises ValueError for a name without a slash, ModuleNotFoundError for an unknown package and
    AttributeError for an unknown type.
    """
    *place, name = identifier.split('/')
    module = import_module('.'.join(place))
    try:
        found: type = getattr(module, name)
    except AttributeError:
        derived = _find_derived(identifier)
        if derived is None:
            raise
        return derived
    return found


def get_message(identifier: str) -> type:
    """Return the message class 'std_msgs/msg/String' or 'std_msgs/String'; ValueError for other forms."""
    found = get_interface(_with_kind(identifier, 'msg'))
    if not is_message(found):
        raise ValueError(f"Expected the full name of a message, got '{identifier}'")
    return found


def get_service(identifier: str) -> type:
    """Return the service class 'std_srvs/srv/SetBool' or 'std_srvs/SetBool'; ValueError for other forms."""
    found = get_interface(_with_kind(identifier, 'srv'))
    if not is_service(found):
        raise ValueError(f"Expected the full name of a service, got '{identifier}'")
    return found


def get_action(identifier: str) -> type:
    """Return the action class named like 'tf2_msgs/action/LookupTransform' or 'tf2_msgs/LookupTransform'.

    Raises ValueError for other forms of names.
    """
    found = get_interface(_with_kind(identifier, 'action'))
    if not is_action(found):
        raise ValueError(f"Expected the full name of an action, got '{identifier}'")
    return found


def get_namespaced_type(identifier: str) -> NamespacedType:
    """Return the NamespacedType of a text a/b/c: c is the name, the parts before are namespaces."""
    *namespaces, name = identifier.split('/')
    return NamespacedType(namespaces, name)


def get_message_namespaced_type(identifier: str) -> NamespacedType:
    """Return the NamespacedType of a message such as 'std_msgs/msg/String' or 'std_msgs/String'."""
    return get_namespaced_type(_with_kind(identifier, 'msg'))


def get_service_namespaced_type(identifier: str) -> NamespacedType:
    """Return the NamespacedType of a service such as 'std_srvs/srv/SetBool' or 'std_srvs/SetBool'."""
    return get_namespaced_type(_with_kind(identifier, 'srv'))


def get_action_namespaced_type(identifier: str) -> NamespacedType:
    """Return the NamespacedType of an action such as 'tf2_msgs/action/LookupTransform'."""
    return get_namespaced_type(_with_kind(identifier, 'action'))


def is_message(interface: object) -> bool:
    """Return whether an object is a message or a message class."""
    return hasattr(interface, 'get_fields_and_field_types')


def is_service(interface: object) -> bool:
    """Return whether an object is a service class."""
    return hasattr(interface, 'Request') and hasattr(interface, 'Response')


def is_action(interface: object) -> bool:
    """Return whether an object is an action class."""
    return all(hasattr(interface, part) for part in ('Goal', 'Result', 'Feedback'))


def _with_kind(identifier: str, kind: str) -> str:
    package, *rest = identifier.split('/')
    return '/'.join((package, kind, *rest)) if len(rest) == 1 else identifier


def _find_derived(identifier: str) -> type | None:
    """Return a class that belongs to a service or action, such as std_srvs/srv/Trigger_Request."""
    try:
        return rosidl_compat.get_interface(identifier)
    except InterfaceError:
        return None
