"""What a user gives for a message: YAML, JSON, `key=value` pairs, or a file (`@request.yaml`)."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from goalwire.cli.outcome import CommandError, Outcome
from goalwire.cli.verbs import did_you_mean
from goalwire.errors import EncodeError

_PAIR = re.compile(r'([A-Za-z_][\w.]*)=(.*)', re.DOTALL)
_MOST = 16 * 1024 * 1024
"""Characters of a file."""

HELP = (
    "values in YAML or JSON ('{a: 1, b: 2}'), as pairs (a=1 pose.x=2.0), or from a file (@request.yaml); "
    'what is left out keeps its default'
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
            _put(values, pair[1].split('.'), _typed(cls, pair[1].split('.'), pair[2]), pair[0])
        return values
    if len(words) > 1:
        odd = next(word for word, pair in zip(words, pairs, strict=True) if pair is None)
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{odd}' is no pair",
            "write key=value for each, or all of it as one word in quotes: '{a: 1, b: 2}'",
        )
    if words[0].startswith('@'):
        return _mapping(_file(words[0][1:]), words[0][1:])
    return _mapping(words[0], 'the value')


def scalar(text: str) -> Any:
    """Return what a text is in YAML. Raises CommandError."""
    import yaml

    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise CommandError(Outcome.BAD_VALUE, f"'{text}' is no YAML: {_problem(error)}", 'quote it') from None


def _mapping(text: str, source: str) -> dict[str, Any]:
    import yaml

    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise CommandError(
            Outcome.BAD_VALUE, f'{source} is no YAML: {_problem(error)}', "write it like '{a: 1, b: [2, 3]}'"
        ) from None
    except RecursionError:
        raise CommandError(Outcome.BAD_VALUE, f'{source} is nested too deeply') from None
    if values is None:
        return {}
    if not isinstance(values, dict):
        raise CommandError(
            Outcome.BAD_VALUE,
            f'{source} names no fields: {text.strip()[:80]!r}',
            "write field and value: '{data: 1}' or data=1",
        )
    return values


def _problem(error: Exception) -> str:
    mark = getattr(error, 'problem_mark', None)
    problem = getattr(error, 'problem', None) or str(error).splitlines()[0]
    return f'{problem} (line {mark.line + 1}, column {mark.column + 1})' if mark else problem


def _file(name: str) -> str:
    try:
        with Path(name).open(encoding='utf-8') as file:
            return file.read(_MOST)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'it is no text in UTF-8'
        raise CommandError(
            Outcome.NOT_FOUND, f"cannot read '{name}': {reason}", 'name another file'
        ) from None


def _put(values: dict[str, Any], path: list[str], value: Any, pair: str) -> None:
    for part in path[:-1]:
        values = values.setdefault(part, {})
        if not isinstance(values, dict):
            raise CommandError(Outcome.BAD_VALUE, f"'{pair}' gives a field twice", 'leave one of them out')
    values[path[-1]] = value


def _typed(cls: Any, path: list[str], text: str) -> Any:
    """Return a pair's value: the text itself where the field is a string, else what it is in YAML."""
    kind = field_type(cls, path)
    if kind.startswith(('string', 'wstring')) and '[' not in kind:
        return text
    return scalar(text)


def field_type(cls: Any, path: Sequence[str]) -> str:
    """Return the type of a field, '' where there is none of that path."""
    from goalwire.cli.lookup import interface

    for at, part in enumerate(path):
        fields: dict[str, str] = cls.get_fields_and_field_types()
        kind = fields.get(part, '')
        if at == len(path) - 1 or '/' not in kind or '[' in kind or '<' in kind:
            return kind if at == len(path) - 1 else ''
        package, name = kind.split('/')
        cls = interface(f'{package}/msg/{name}')
    return ''


def filled(cls: Any, values: Mapping[str, Any], title: str) -> Any:
    """Return a message of class `cls` with these values; `title` is its type. Raises CommandError."""
    message = cls()
    fill(message, values, title)
    return message


def fill(message: Any, values: Mapping[str, Any], title: str, *, stamps: bool = False) -> list[Any]:
    """Set fields of a message; with `stamps`, 'auto' and 'now' are times, and what sets them is returned.

    Raises CommandError, also for what can be set and not be sent, such as a number that is too large: before
    anybody is waited for.
    """
    from rosidl_runtime_py import set_message_fields

    from goalwire.entities.type_support import message_support

    _check_names(message, values, title)
    try:
        set_stamps: list[Any] = set_message_fields(
            message, dict(values), expand_header_auto=stamps, expand_time_now=stamps
        )
    except (AssertionError, AttributeError, OverflowError, TypeError, ValueError) as error:
        problem = f'{_culprit(message, values)}{" ".join(str(error).split())}'
        raise _misfit(title, problem) from None
    try:
        message_support(type(message)).encode(message)
    except EncodeError as error:
        _, _, problem = ' '.join(str(error).split()).partition(': ')  # behind the type
        raise _misfit(title, problem) from None
    return set_stamps


def _misfit(title: str, problem: str) -> CommandError:
    return CommandError(Outcome.BAD_VALUE, f'{title}: {problem}', f'see: ros2 interface show {title}')


def _culprit(message: Any, values: Mapping[str, Any]) -> str:
    """Return which of several fields cannot be set, as 'name: '."""
    from rosidl_runtime_py import set_message_fields

    for name, value in values.items():
        try:
            set_message_fields(type(message)(), {name: value})
        except (AssertionError, AttributeError, OverflowError, TypeError, ValueError):
            return f'{name}: '
    return ''


def _check_names(message: Any, values: Mapping[str, Any], title: str) -> None:
    fields = message.get_fields_and_field_types()
    for name, value in values.items():
        if name not in fields:
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
