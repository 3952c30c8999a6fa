"""Checks names by the rules of ROS 2. An error has ROS 2's own text, and the index of the name's first fault.

The rules are those of rmw (node names, namespaces, fully qualified names) and rcl (names as users write them,
with `~` and `{substitutions}`). Indices count characters.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TYPE_CHECKING

from goalwire.errors import LocalError, point_at
from goalwire.patterns import Pattern

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

MAX_NODE_NAME = 255
MAX_NAMESPACE = 245
MAX_TOPIC_NAME = 247
"""The longest topic name: of DDS's 255 characters, rmw reserves 8 for prefixes such as `rq/`."""

_LONGEST_KEPT = 1000  # the most characters of a name whose validation is cached
_DIGITS = frozenset('0123456789')
_NOT_NODE = Pattern(r'[^A-Za-z0-9_]')
_NOT_FULL = Pattern(r'[^A-Za-z0-9_/]')
_BAD_TOKEN_START = Pattern(r'/([/0-9])')
_NUMBERED_TOKEN = Pattern(r'/[0-9]')
_PIECE = Pattern(r'\{([^{}]*)(\}|\{|$)|[^A-Za-z0-9_/]')

_NODE_CHARACTERS = "must not contain characters other than alphanumerics or '_'"
_FULL_CHARACTERS = "must not contain characters other than alphanumerics, '_', or '/'"
_TOPIC_CHARACTERS = "must not contain characters other than alphanumerics, '_', '~', '{', or '}'"
_MISPLACED_TILDE = "topic name must not have tilde '~' unless it is the first character"
_UNBALANCED = "topic name must not have unmatched (unbalanced) curly braces '{}'"

Fault = tuple[str, int]


class InvalidName(LocalError, ValueError):
    """An error for a name that ROS 2 forbids, with ROS 2's text `reason` and the fault's `index` in the name.

    Programs get rclpy's error in its place: a NameValidationException or a TopicExpansionError.
    """

    def __init__(self, kind: str, name: str, reason: str, index: int) -> None:
        self.kind = kind
        self.name = name
        self.reason = reason
        self.index = index
        super().__init__(point_at(kind, name, reason, index))


class UnknownSubstitution(InvalidName):
    """An error for a name with an unknown `{substitution}`. Programs get TopicExpansionError instead."""


def validate_node_name(name: str) -> None:
    """Raise InvalidName unless `name` is a valid node name."""
    _raise_first('node name', name, _node_faults)


def validate_namespace(namespace: str) -> None:
    """Raise InvalidName unless `namespace` is a valid absolute namespace."""
    _raise_first('namespace', namespace, _namespace_faults)


def validate_topic_name(name: str, *, is_service: bool = False) -> None:
    """Raise InvalidName unless users may write this topic name; it may be relative and have substitutions."""
    _raise_first('service name' if is_service else 'topic name', name, _topic_faults)


def validate_full_topic_name(name: str, *, is_service: bool = False) -> None:
    """Raise InvalidName unless `name` is valid and fully qualified: absolute, without substitutions."""
    _raise_first('service name' if is_service else 'topic name', name, _full_topic_faults)


def validate_enclave(enclave: str) -> None:
    """Raise InvalidName unless `enclave` is an absolute path of names (rmw_validate_enclave_name)."""
    _raise_first('context name', enclave, _enclave_faults)


def is_hidden_name(name: str) -> bool:
    """Tell whether a token of a name starts with `_`. Tools show such names only on request."""
    return any(token.startswith('_') for token in name.split('/'))


def _raise_first(kind: str, name: str, faults: Callable[[str], Iterator[Fault]]) -> None:
    first = _first if len(name) <= _LONGEST_KEPT else _first.__wrapped__
    if (fault := first(faults, name)) is not None:
        raise InvalidName(kind, name, *fault)


@lru_cache(maxsize=256)  # each endpoint of a node validates the node's names again
def _first(faults: Callable[[str], Iterator[Fault]], name: str) -> Fault | None:
    return next(faults(name), None)


def _node_faults(name: str) -> Iterator[Fault]:
    if not name:
        yield 'node name must not be empty', 0
    elif forbidden := _NOT_NODE.search(name):
        yield f'node name {_NODE_CHARACTERS}', forbidden.start()
    elif name[0] in _DIGITS:
        yield 'node name must not start with a number', 0
    elif len(name) > MAX_NODE_NAME:
        yield f"node name length should not exceed '{MAX_NODE_NAME}'", MAX_NODE_NAME - 1


def _namespace_faults(namespace: str, what: str = 'namespace') -> Iterator[Fault]:
    if namespace == '/':
        return
    if len(namespace) > 1 and namespace.startswith('/') and namespace.endswith('/'):
        yield f"{what} must not end with a '/', unless only a '/'", len(namespace) - 1
    yield from _absolute_faults(what, namespace)
    if len(namespace) > MAX_NAMESPACE:
        yield f"{what} should not exceed 'RMW_NAMESPACE_MAX_NAME_LENGTH'", MAX_NAMESPACE - 1


def _enclave_faults(enclave: str) -> Iterator[Fault]:
    return _namespace_faults(enclave, 'context name')


def _full_topic_faults(name: str) -> Iterator[Fault]:
    yield from _absolute_faults('topic name', name)
    if len(name) > MAX_TOPIC_NAME:
        yield "topic length should not exceed '255U - 8U'", MAX_TOPIC_NAME - 1


def _absolute_faults(what: str, name: str) -> Iterator[Fault]:
    if not name:
        yield f'{what} must not be empty', 0
    elif name[0] != '/':
        yield f"{what} must be absolute, it must lead with a '/'", 0
    elif name.endswith('/'):
        yield f"{what} must not end with a '/'", len(name) - 1
    elif forbidden := _NOT_FULL.search(name):
        yield f'{what} {_FULL_CHARACTERS}', forbidden.start()
    elif token := _BAD_TOKEN_START.search(name):
        fault = "contain repeated '/'" if token[1] == '/' else 'have a token that starts with a number'
        yield f'{what} must not {fault}', token.start(1)


def _topic_faults(name: str) -> Iterator[Fault]:
    if not name:
        yield 'topic name must not be empty string', 0
        return
    if name[0] in _DIGITS:
        yield 'topic name token must not start with a number', 0
    if name.endswith('/'):
        yield 'topic name must not end with a forward slash', len(name) - 1
    for piece in _PIECE.finditer(name):
        yield from _piece_faults(piece)
    if name.startswith('~') and not name.startswith('~/') and name != '~':
        yield "topic name must not have a tilde '~' that is not followed by a forward slash '/'", 1
    if token := _NUMBERED_TOKEN.search(name):
        yield 'topic name token must not start with a number', token.start() + 1


def _piece_faults(piece: re.Match[str]) -> Iterator[Fault]:
    """Yield the faults of one `{substitution}`, or of one character that is not allowed in every place."""
    start, text = piece.start(), piece[0]
    if text[0] == '{':
        yield from _substitution_faults(piece)
    elif text == '}':
        yield _UNBALANCED, start
    elif text != '~':
        yield f'topic name {_TOPIC_CHARACTERS}', start
    elif start:
        yield _MISPLACED_TILDE, start


def _substitution_faults(piece: re.Match[str]) -> Iterator[Fault]:
    inside, end = piece[1], piece[2]
    if inside and inside[0] in _DIGITS:
        yield 'substitution name must not start with a number', piece.start(1)
    if forbidden := _NOT_NODE.search(inside):
        reason = _MISPLACED_TILDE if forbidden[0] == '~' else f'substitution name {_NODE_CHARACTERS}'
        yield reason, piece.start(1) + forbidden.start()
    if end == '{':
        yield f'substitution name {_NODE_CHARACTERS}', piece.start(2)
    if not end:
        yield _UNBALANCED, piece.start()
