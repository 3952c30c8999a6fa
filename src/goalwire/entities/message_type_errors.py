"""Says what was given in place of a message, and what to write: the texts of TypeErrors."""

from __future__ import annotations


def explain_wrong_message(expected: type, given: object) -> str:
    """Return what is expected, what was given and what to write instead."""
    wanted = python_name(expected)
    if given is expected or given is _enclosing(expected):
        return f'expected {wanted}, got the class: write {short_name(expected)}(), with the parentheses'
    if isinstance(given, type):
        return (
            f'expected {wanted}, got the class {given.__qualname__}: give an object of {short_name(expected)}'
        )
    if hasattr(type(given), 'get_fields_and_field_types'):
        return f'expected {wanted}, got {python_name(type(given))}: write {short_name(expected)}(…)'
    fields: dict[str, str] = expected.get_fields_and_field_types()  # type: ignore[attr-defined]
    first = next(iter(fields), '')
    shown = repr(given) if len(repr(given)) <= _LONGEST and len(fields) == 1 else '…'
    call = f'{short_name(expected)}({first}={shown})' if first else f'{short_name(expected)}()'
    return f'expected {wanted}, got {type(given).__name__}: write {call}'


_LONGEST = 30


def python_name(cls: type) -> str:
    """Return how a program names a message's class: 'std_msgs.msg.String', 'std_srvs.srv.Trigger.Request'."""
    return f'{cls.__module__.rpartition("._")[0] or cls.__module__}.{short_name(cls)}'


def short_name(cls: type) -> str:
    """Return the last part of a type's name: 'String', 'Trigger.Request'."""
    base, underscore, part = cls.__name__.rpartition('_')
    return f'{base}.{part}' if underscore else part


def _enclosing(cls: type) -> object:
    """Return the service or action that a request or a goal is of, if it is loaded."""
    import sys

    module = sys.modules.get(cls.__module__)
    return getattr(module, cls.__name__.rpartition('_')[0], None)
