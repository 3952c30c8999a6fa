"""Messages as users write them: YAML, JSON, `key=value` pairs, or a file (`@request.yaml`)."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import did_you_mean
from goalwire.errors import EncodeError, FieldValueError
from goalwire.idl.field_values import fit_fields, plain_values, read_yaml
from goalwire.idl.model import MessageDefinition

_PAIR = re.compile(r'([A-Za-z_][\w.]*)=(.*)', re.DOTALL)
_MOST = 16 * 1024 * 1024
"""The longest file, in characters."""

HELP = (
    "values in YAML or JSON ('{a: 1, b: 2}'), as pairs (a=1 pose.x=2.0), or from a file (@request.yaml); "
    "what is left out keeps its default; a header may be 'auto', a time 'now'"
)


def read_values(words: Sequence[str], cls: Any, *, stdin: bool = False) -> dict[str, Any]:
    """Return the fields that are given for a message of class `cls`. Raises CommandError."""
    if stdin:
        return _mapping(sys.stdin.read(_MOST), 'standard input')
    if not words:
        return {}
    pairs = [_PAIR.fullmatch(word) for word in words]
    if all(pairs):
        values: dict[str, Any] = {}
        for pair in pairs:
            assert pair is not None
            _put(values, pair[1].split('.'), _read_value(cls, pair[1].split('.'), pair[2]), pair[0])
        return values
    if len(words) > 1:
        odd = next(word for word, pair in zip(words, pairs, strict=True) if pair is None)
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{odd}' is not a pair",
            "write key=value for each, or all of it as one word in quotes: '{a: 1, b: 2}'",
        )
    if words[0].startswith('@'):
        return _mapping(_file(words[0][1:]), words[0][1:])
    return _mapping(words[0], 'the value')


def _mapping(text: str, source: str) -> dict[str, Any]:
    try:
        values = read_yaml(text)
    except FieldValueError as error:
        raise CommandError(
            Outcome.BAD_VALUE, f'{source}: {error.problem}', "write it like '{a: 1, b: [2, 3]}'"
        ) from None
    if plain_values(values) is None:
        return {}
    if not isinstance(values, dict):
        raise CommandError(
            Outcome.BAD_VALUE,
            f'{source} names no fields: {text.strip()[:80]!r}',
            "write field and value: '{data: 1}' or data=1",
        )
    return values


def _file(name: str) -> str:
    try:
        with Path(name).open(encoding='utf-8') as file:
            return file.read(_MOST)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'it is not a text in UTF-8'
        raise CommandError(
            Outcome.NOT_FOUND, f"cannot read '{name}': {reason}", 'name another file'
        ) from None


def _put(values: dict[str, Any], path: list[str], value: Any, pair: str) -> None:
    for part in path[:-1]:
        values = values.setdefault(part, {})
        if not isinstance(values, dict):
            raise CommandError(Outcome.BAD_VALUE, f"'{pair}' gives a field twice", 'leave one of them out')
    values[path[-1]] = value


def _read_value(cls: Any, path: list[str], text: str) -> Any:
    """Return the value of a pair: the text itself for a string field, otherwise the text read as YAML."""
    kind = field_type(cls, path)
    if kind.startswith(('string', 'wstring')) and '[' not in kind:
        return text
    try:
        return read_yaml(text)
    except FieldValueError as error:
        raise CommandError(Outcome.BAD_VALUE, f"'{text}': {error.problem}", 'quote it') from None


def field_type(cls: Any, path: Sequence[str]) -> str:
    """Return the type of the field at a path; '' if there is no such field."""
    from goalwire.apps.cli.framework.lookup import interface

    for at, part in enumerate(path):
        fields: dict[str, str] = cls.get_fields_and_field_types()
        kind = fields.get(part, '')
        if at == len(path) - 1 or '/' not in kind or '[' in kind or '<' in kind:
            return kind if at == len(path) - 1 else ''
        package, name = kind.split('/')
        cls = interface(f'{package}/msg/{name}')
    return ''


def fill(message: Any, values: Mapping[str, Any], title: str) -> list[Callable[[Any], None]]:
    """Set fields of a message of the type `title`. Return functions that set its 'now' and 'auto' times.

    Call each of these functions with the current time before the message is sent. Raises CommandError for a
    value that does not fit its field, or that cannot be serialized.
    """
    from rosidl_runtime_py import set_message_fields

    from goalwire.entities.type_support import message_support
    from goalwire.idl.rosidl_compat import definition_of

    _check_names(message, values, title)
    definition = definition_of(type(message))
    assert isinstance(definition, MessageDefinition)
    try:
        fitted = fit_fields(definition, values, stamps=True)
        set_stamps = set_message_fields(message, fitted, expand_header_auto=True, expand_time_now=True)
        message_support(type(message)).encode(message)
    except FieldValueError as error:
        raise _misfit(title, str(error)) from None
    except EncodeError as error:
        _, _, problem = ' '.join(str(error).split()).partition(': ')  # drops the type before the colon
        raise _misfit(title, problem) from None
    return set_stamps


def _misfit(title: str, problem: str) -> CommandError:
    return CommandError(Outcome.BAD_VALUE, f'{title}: {problem}', f'see: ros2 interface show {title}')


def _check_names(message: Any, values: Mapping[str, Any], title: str) -> None:
    fields = message.get_fields_and_field_types()
    for name, value in values.items():
        if name not in fields:
            field, colon, rest = str(name).partition(':')
            if colon and field in fields:
                problem = f"{title}: '{name}' has no blank behind the colon"
                raise CommandError(Outcome.BAD_VALUE, problem, f"write '{field}: {rest}'")
            near = did_you_mean(str(name), list(fields)) or (
                f'its fields are: {", ".join(fields)};' if fields else 'it has no fields;'
            )
            raise CommandError(
                Outcome.BAD_VALUE,
                f"{title} has no field '{name}'",
                f'{near} see: ros2 interface show {title}',
            )
        nested = getattr(message, name)
        if isinstance(value, Mapping) and hasattr(nested, 'get_fields_and_field_types'):
            _check_names(nested, value, fields[name].replace('/', '/msg/'))
