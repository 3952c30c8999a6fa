"""Classes by name and names by class, for goalwire's own classes and for those of a real rosidl."""

from __future__ import annotations

from goalwire.errors import UnknownInterfaceError
from goalwire.idl import classes, registry


def type_name(cls: type) -> str:
    """Return 'std_msgs/msg/String' for the class String; raises UnknownInterfaceError for other classes."""
    own = classes.own_definition(cls)
    if own is not None:
        return own.full_name
    package, _, rest = getattr(cls, '__module__', '').partition('.')
    kind = rest.partition('.')[0]
    if kind not in ('msg', 'srv', 'action') or not hasattr(type(cls), '_TYPE_SUPPORT'):
        raise UnknownInterfaceError(f'{cls!r} is no message, service or action class')
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
    """Return the class of any full name, derived types included."""
    return classes.find_class(name)


def _class_of_kind(name: str, kind: str) -> type:
    package, own, type_ = registry.split_name(name)
    if own != kind:
        raise UnknownInterfaceError(f'{name} is of kind {own}, not {kind}')
    return classes.find_class(f'{package}/{own}/{type_}')
