"""All interface definitions by their full names; each is parsed once, from a file or a registered text."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Mapping

from goalwire.errors import InterfaceError, InterfaceSyntaxError, UnknownInterfaceError
from goalwire.files import LARGEST_DEFINITION, read_regular, show
from goalwire.idl import grammar, search_path, workspace
from goalwire.idl.model import ActionDefinition, Definition, MessageDefinition, ServiceDefinition

_Parser = Callable[..., Definition]
_PARSERS: dict[str, _Parser] = {
    'msg': grammar.parse_message,
    'srv': grammar.parse_service,
    'action': grammar.parse_action,
}

_lock = threading.Lock()
_parsed: dict[str, Definition] = {}
_texts: dict[str, dict[str, str]] = {}  # package -> 'msg/Name' -> text, from register_definitions


def register_definitions(package: str, definitions: Mapping[str, str]) -> None:
    """Register types of a package by the texts of their definitions: {'msg/Foo': 'int32 x', 'srv/Bar': …}.

    A registered text takes precedence over files. Raises InterfaceError if a type already has another text.
    """
    for name, text in definitions.items():
        kind, _, type_name = name.partition('/')
        if kind not in _PARSERS:
            raise InterfaceError(f'{package}/{name}: a definition is named msg/Name, srv/Name or action/Name')
        parsed = _PARSERS[kind](text, package, type_name, source=f'{package}/{name}.{kind}')
        known = _parsed.get(parsed.full_name)
        if known is not None and known != parsed:
            raise InterfaceError(f'{package}/{name} is already defined differently')
    with _lock:
        _texts.setdefault(package, {}).update(definitions)


def registered_types(package: str) -> frozenset[str]:
    """Return the names of the types registered for a package by register_definitions, such as 'msg/Foo'."""
    with _lock:
        return frozenset(_texts.get(package, ()))


def definition(full_name: str) -> Definition:
    """Return the definition of 'pkg/msg/Name', 'pkg/srv/Name', 'pkg/action/Name' or of a type derived from
    these.

    Raises UnknownInterfaceError, or InterfaceSyntaxError for text that breaks the grammar.
    """
    found = _parsed.get(full_name)
    if found is None:
        package, kind, name = split_name(full_name)
        parsed = parse(package, kind, name.partition('_')[0])
        with _lock:
            for item in with_derived(parsed):
                _parsed.setdefault(item.full_name, item)
        found = _parsed.get(full_name)
        if found is None:
            raise UnknownInterfaceError(f'{full_name}: {parsed.full_name} has no part of this name')
    return found


def definition_text(full_name: str) -> str:
    """Return the text that defines 'pkg/msg/Name'; raises the same errors as `definition` does."""
    return _text(*split_name(full_name))[0]


def message_definition(full_name: str) -> MessageDefinition:
    """Return a message's definition. Raises as `definition` does, also for a service's or action's name."""
    found = definition(full_name)
    if not isinstance(found, MessageDefinition):
        raise UnknownInterfaceError(f'{full_name} is not a message')
    return found


def split_name(full_name: str) -> tuple[str, str, str]:
    """Split 'pkg/msg/Name'; raises UnknownInterfaceError for anything else."""
    parts = full_name.split('/')
    # Only identifiers are safe: other parts could make a path or an import that leads elsewhere.
    if len(parts) != 3 or parts[1] not in _PARSERS or not all(map(str.isidentifier, parts)):
        raise UnknownInterfaceError(
            f'{full_name!r} is not an interface name (write package/msg/Name, …/srv/… or …/action/…)'
        )
    return parts[0], parts[1], parts[2]


def with_derived(parsed: Definition) -> Iterator[Definition]:
    """Yield a definition, and the definitions that ROS 2 derives from it."""
    yield parsed
    if isinstance(parsed, (ServiceDefinition, ActionDefinition)):
        yield from parsed.messages
    if isinstance(parsed, ActionDefinition):
        yield parsed.send_goal
        yield parsed.get_result


def parse(package: str, kind: str, name: str) -> Definition:
    """Parse a type's text again, because its file may have changed. Raises as `definition` does."""
    text, source = _text(package, kind, name)
    return _PARSERS[kind](text, package, name, source=source)


def _text(package: str, kind: str, name: str) -> tuple[str, str]:
    """Return the text of a type's definition, and the name of its file for errors."""
    key = f'{kind}/{name}'
    with _lock:
        text = _texts.get(package, {}).get(key)
    if text is not None:
        return text, f'{package}/{key}.{kind}'
    found = search_path.find_imported_package(package, kind)
    names = workspace.definition_names(found.folder, kind) if found else []
    if found and name in names:
        found.tell_use()
        file = os.path.join(found.folder, kind, f'{name}.{kind}')
        return read_definition(file), file
    if found is None and package not in _texts:
        refused = search_path.explain_refused()
        raise UnknownInterfaceError(
            f'{package}/{key}: no package {package!r} was found '
            '(name its folder in GOALWIRE_INTERFACE_PATH, or source the workspace that has it)'
            f'{f"; {refused}" if refused else ""}'
        )
    known = {*(f'{kind}/{other}' for other in names), *registered_types(package)}
    from difflib import get_close_matches

    close = get_close_matches(key, known, n=3, cutoff=0.7)
    hint = f'; close: {", ".join(close)}' if close else ''
    if overridden := search_path.explain_overridden(package):
        hint += f'; {overridden}'
    place = f' in {found.folder}' if found else ''
    elsewhere = _elsewhere(name)
    if elsewhere and not close:
        hint = f'; write {elsewhere}' + hint
    raise UnknownInterfaceError(f'{package}/{key}: the package has no such type{place}{hint}')


def _elsewhere(name: str) -> str:
    """Return the full name for a type such as Header, whose package users often mistake; '' for others."""
    return next((f'{package}/{name}' for package, names in _OFTEN_MEANT.items() if name in names), '')


_OFTEN_MEANT = {
    'std_msgs': ('Header', 'String', 'Bool', 'ColorRGBA'),
    'builtin_interfaces': ('Time', 'Duration'),
    'geometry_msgs': (
        'Point',
        'Pose',
        'PoseStamped',
        'Quaternion',
        'Transform',
        'Twist',
        'Vector3',
        'Wrench',
    ),
    'sensor_msgs': ('Image', 'Imu', 'JointState', 'LaserScan', 'PointCloud2'),
    'nav_msgs': ('Odometry', 'OccupancyGrid', 'Path'),
}


def read_definition(file: str) -> str:
    """Read a definition file. Raises InterfaceError, and InterfaceSyntaxError if it is not UTF-8."""
    try:
        data = read_regular(file, LARGEST_DEFINITION)
    except OSError as error:
        raise InterfaceError(f'{show(file)}: cannot be read: {error.strerror}') from error
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        line = data.count(b'\n', 0, error.start) + 1
        raise InterfaceSyntaxError(
            file, line, 1, 'this line is not UTF-8 text: save the file as UTF-8'
        ) from None
