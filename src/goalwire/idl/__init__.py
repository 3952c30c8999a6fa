"""Interfaces without a build step: .msg, .srv and .action files become classes at their first use."""

TYPE_CHECKING = False  # importing typing takes 5 ms, and the import hook loads this package at every start
if TYPE_CHECKING:
    from goalwire.cdr.type_hash import has_buffer_fields as has_buffer_fields
    from goalwire.cdr.type_hash import type_hash as type_hash
    from goalwire.idl.registry import definition as definition
    from goalwire.idl.registry import register_definitions as register_definitions
    from goalwire.idl.rosidl_compat import get_action as get_action
    from goalwire.idl.rosidl_compat import get_interface as get_interface
    from goalwire.idl.rosidl_compat import get_message as get_message
    from goalwire.idl.rosidl_compat import get_service as get_service
    from goalwire.idl.rosidl_compat import type_name as type_name

_ORIGINS = {
    'definition': 'goalwire.idl.registry',
    'get_action': 'goalwire.idl.rosidl_compat',
    'get_interface': 'goalwire.idl.rosidl_compat',
    'get_message': 'goalwire.idl.rosidl_compat',
    'get_service': 'goalwire.idl.rosidl_compat',
    'has_buffer_fields': 'goalwire.cdr.type_hash',
    'register_definitions': 'goalwire.idl.registry',
    'type_hash': 'goalwire.cdr.type_hash',
    'type_name': 'goalwire.idl.rosidl_compat',
}
__all__ = list(_ORIGINS)


def __getattr__(name: str) -> object:
    origin = _ORIGINS.get(name)
    if origin is None:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    from importlib import import_module  # imported here, not above: it takes 0.3 ms

    value = getattr(import_module(origin), name)
    globals()[name] = value
    return value
