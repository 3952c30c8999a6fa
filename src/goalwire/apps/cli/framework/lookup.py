"""Finds a name of the user in the graph, or among the interfaces. Errors suggest similar names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.robots import on_robot
from goalwire.apps.cli.framework.verbs import did_you_mean
from goalwire.errors import did_you_mean as suggest
from goalwire.errors import with_advice

if TYPE_CHECKING:
    from goalwire.graph.names import NamesAndTypes

KINDS = {'msg': 'message', 'srv': 'service', 'action': 'action'}
_TYPE = re.compile(r'[A-Za-z]\w*((/|\.|::)(msg|srv|action))?(/|\.|::)[A-Za-z]\w*')
_SEPARATOR = re.compile(r'/|\.|::')
_UNUSABLE = re.compile(r'[^\w/~{}]')


def full_name(text: str, what: str) -> str:
    """Return '/a/b' for '/a/b', 'a/b', 'a//b' and '/a/b/'. Raises CommandError for an invalid name.

    If the user has chosen a robot, 'a/b' becomes '/robot/a/b'.
    """
    name = '/' + '/'.join(part for part in on_robot(text).split('/') if part)
    found = _UNUSABLE.search(name)
    if found is not None or name == '/':
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{text}' is not a name of a {what}",
            'names are made of letters, digits, underscores and slashes',
        )
    return name


def unknown(what: str, name: str, known: Iterable[str], command: str) -> CommandError:
    """Return the error for a name that is not in the graph; it tells that `command` lists the names."""
    from goalwire.graph.near_misses import similar_names

    advice = with_advice(suggest(similar_names(name, sorted(known))), f'see: {command}')
    return CommandError(Outcome.NOT_FOUND, f"there is no {what} '{name}'", advice)


def types_of(found: NamesAndTypes, name: str) -> list[str] | None:
    """Return the types of a name; None if `found` does not contain the name."""
    return next((types for each, types in found if each == name), None)


def looks_like_type(word: str) -> bool:
    """Return whether a word of the command line is a type: std_msgs/msg/String, std_msgs/String and so on."""
    return _TYPE.fullmatch(word) is not None


def split_name(text: str) -> list[str]:
    """Return the parts of the name of a type."""
    return _SEPARATOR.split(text)


def type_name(text: str, kind: str | None) -> str:
    """Return 'pkg/kind/Name' for 'pkg/Name', 'pkg.kind.Name', 'pkg::kind::Name' too.

    If `kind` is None, any kind is accepted, but the text must contain it. Raises CommandError for a text that
    is not the name of a type, and for a type of another kind.
    """
    parts = split_name(text)
    if len(parts) == 2 and kind is not None:
        parts.insert(1, kind)
    if len(parts) != 3 or not all(parts) or parts[1] not in KINDS:
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{text}' is not a type",
            f'write package/{kind or "msg"}/Name; see: ros2 interface list',
        )
    if kind is not None and parts[1] != kind:
        raise CommandError(
            Outcome.BAD_VALUE,
            f'{"/".join(parts)} is {_a(KINDS[parts[1]])}, and {_a(KINDS[kind])} is asked for',
            'see: ros2 interface list',
        )
    return '/'.join(parts)


def interface(name: str) -> Any:
    """Return the class of 'pkg/kind/Name', also of derived types. Raises CommandError for an unknown type."""
    from rosidl_runtime_py.utilities import get_interface

    from goalwire.errors import InterfaceSyntaxError, UnknownInterfaceError

    try:
        return get_interface(name)
    except InterfaceSyntaxError as error:
        raise CommandError(Outcome.FAILED, f"the type '{name}' cannot be used: {error}") from None
    except (ImportError, AttributeError, ValueError, UnknownInterfaceError):
        raise CommandError(Outcome.NOT_FOUND, f"there is no type '{name}' here", _near_types(name)) from None


def interface_in_use(name: str) -> Any:
    """Do as `interface`, but request an unknown type from the nodes that use it, which takes a second."""
    try:
        return interface(name)
    except CommandError as error:
        from goalwire.observe.described_types import fetch_type_now

        if error.outcome is not Outcome.NOT_FOUND or not fetch_type_now(name):
            raise
    return interface(name)


def _near_types(name: str) -> str:
    """Return advice for an unknown type."""
    from rosidl_runtime_py import get_interface_packages, get_interfaces

    from goalwire.idl.search_path import explain_overridden, explain_refused

    package, kind, _ = name.split('/')
    packages = sorted(get_interface_packages())
    if package not in packages:
        found = [did_you_mean(package, packages), explain_refused()]
        known = ' '.join(filter(None, found))
        return known or 'install its package, or name its folder in GOALWIRE_INTERFACE_PATH'
    names = [
        f'{package}/{each}' for each in get_interfaces([package]).get(package, ()) if each.startswith(kind)
    ]
    near = explain_overridden(package) or did_you_mean(name, names)
    return near or f'see: ros2 interface package {package}'


def split_type(words: Sequence[str], kind: str) -> tuple[str | None, list[str]]:
    """Split a type off the words if the first word is a type: return the type, or None, and the rest."""
    if words and looks_like_type(words[0]):
        return type_name(words[0], kind), list(words[1:])
    return None, list(words)


def only_type(types: Sequence[str], what: str, name: str, prog: str) -> str:
    """Return the one type that a name has in the graph; raises CommandError if there are more."""
    if len(types) == 1:
        return types[0]
    raise CommandError(
        Outcome.FAILED,
        f"the {what} '{name}' has more than one type: {', '.join(types)}",
        f'name one of them: {prog} {name} {types[0]}',
    )


def one_line(text: str) -> str:
    """Return a text without line breaks."""
    return ' '.join(text.split())


def _a(noun: str) -> str:
    return f'{"an" if noun[0] in "aeiou" else "a"} {noun}'
