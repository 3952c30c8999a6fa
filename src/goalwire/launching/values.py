"""Texts with substitutions, and their values: strings, numbers, booleans, lists.

As in launch, a text that becomes a number or a list is parsed by YAML's rules.
"""

from __future__ import annotations

import typing
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import yaml

from goalwire.errors import BadLaunchValueError, InvalidConditionExpressionError, SubstitutionFailure
from goalwire.launching.model import LaunchContext, SomeSubstitutions, Substitution

SCALARS = (bool, int, float, str)


class TextSubstitution(Substitution):
    """A substitution whose result is a fixed text."""

    def __init__(self, *, text: str) -> None:
        if not isinstance(text, str):
            raise TypeError(f'TextSubstitution expects a string, got {text!r}')
        self._text = text

    @property
    def text(self) -> str:
        return self._text

    def describe(self) -> str:
        return f"'{self._text}'"

    def perform(self, context: LaunchContext) -> str:
        return self._text


def normalize_to_list_of_substitutions(subs: SomeSubstitutions) -> list[Substitution]:
    """Make a list of substitutions from a text, a substitution, or several of both. Raises TypeError."""
    if isinstance(subs, str | Path | Substitution):
        return [_substitution(subs)]
    if isinstance(subs, Iterable):
        return [_substitution(item) for item in subs]
    raise TypeError(f'expected a string, a substitution or a list of them, got {subs!r:.200}')


def _substitution(item: object) -> Substitution:
    if isinstance(item, Substitution):
        return item
    if isinstance(item, str | Path):
        return TextSubstitution(text=str(item))
    raise TypeError(f'expected a string or a substitution, got {item!r:.200}')


def perform_substitutions(context: LaunchContext, subs: Iterable[Substitution]) -> str:
    """Evaluate substitutions, and return their texts joined."""
    return ''.join([context.perform_substitution(sub) for sub in subs])


def perform_text(context: LaunchContext, some: SomeSubstitutions) -> str:
    return perform_substitutions(context, normalize_to_list_of_substitutions(some))


def describe_text(some: SomeSubstitutions) -> str:
    return ' + '.join(sub.describe() for sub in normalize_to_list_of_substitutions(some))


def is_substitution(value: object) -> bool:
    """Return whether a value is a substitution, or a list of texts and at least one substitution."""
    if isinstance(value, Substitution):
        return True
    return (
        isinstance(value, Sequence)
        and not isinstance(value, str)
        and all(isinstance(item, Substitution | str) for item in value)
        and any(isinstance(item, Substitution) for item in value)
    )


def scalar_type(data_type: object) -> tuple[Any, bool]:
    """Return a type's scalar type, and if it is a list: (int, True) for `List[int]`. Raises ValueError."""
    inner = typing.get_args(data_type)
    if typing.get_origin(data_type) is list and inner and inner[0] in SCALARS:
        return inner[0], True
    if data_type in SCALARS:
        return data_type, False
    raise ValueError(f'unrecognised data type {data_type!r}: int, float, bool, str or List of one of them')


def coerce_to_type(value: str, data_type: object = None, can_be_str: bool = False) -> Any:
    """Convert a text to a type; without a type, convert it by YAML's rules.

    With `can_be_str` a text that does not fit stays a text: it may hold a substitution. Raises ValueError.
    """
    if data_type is None:
        return _by_yaml(value, can_be_str=can_be_str)
    scalar, many = scalar_type(data_type)
    if many:
        items = _by_yaml(value, can_be_str=can_be_str)
        allowed = (scalar, str) if can_be_str else (scalar,)
        if not isinstance(items, list) or not all(_is_of(item, allowed) for item in items):
            raise ValueError(f"cannot read '{value}' as a list of {scalar.__name__}")
        return items
    if scalar is str:
        return value
    if scalar is bool:
        found = as_bool(value)
        if found is not None:
            return found
    else:
        try:
            return scalar(value)
        except ValueError:
            pass
    if can_be_str:
        return value
    raise ValueError(f"cannot read '{value}' as {scalar.__name__}")


def as_bool(text: str) -> bool | None:
    """Return True for true, yes, on, 1 and False for false, no, off, 0, whatever the case; else None."""
    text = text.strip().lower()
    if text in {'true', 'yes', 'on', '1'}:
        return True
    return False if text in {'false', 'no', 'off', '0'} else None


def _by_yaml(value: str, *, can_be_str: bool) -> Any:
    if not isinstance(value, str):
        raise TypeError(f'expected a string, got {value!r:.100}')
    if not value:
        return value
    try:
        found = yaml.safe_load(value)
    except yaml.YAMLError as error:
        if can_be_str:
            return value
        raise ValueError(f"cannot read '{value}' by YAML's rules") from error
    if isinstance(found, list) and all(isinstance(item, SCALARS) for item in found):
        kinds = {type(item) for item in found} - ({str} if can_be_str else set())
        if len(kinds) > 1:
            raise ValueError(f"'{value}' is a list of different types")
        return found
    if isinstance(found, SCALARS):
        return found
    if can_be_str:
        return value
    raise ValueError(f"'{value}' is neither a number, a boolean, a string nor a list of them")


def _is_of(value: object, kinds: tuple[type, ...]) -> bool:
    return type(value) in kinds or (float in kinds and type(value) is int)


def normalize_typed_substitution(value: Any, data_type: object = None) -> Any:
    """Return a value of the given type, or a list of substitutions that will be evaluated to one.

    Raises TypeError for other objects.
    """
    if isinstance(value, SCALARS):
        if data_type is not None:
            scalar, many = scalar_type(data_type)
            if many or not _is_of(value, (scalar,)):
                raise _misfit(value, scalar, many=many)
        return value
    if is_substitution(value):
        return normalize_to_list_of_substitutions(value)
    if isinstance(value, Iterable):
        scalar = None if data_type is None else scalar_type(data_type)[0]
        return [
            normalize_to_list_of_substitutions(item) if is_substitution(item) else _plain(item, scalar)
            for item in value
        ]
    raise TypeError(f'expected a value, a substitution or a list of them, got {value!r:.200}')


_EXAMPLES = {int: '3', float: '1.5', bool: 'true', str: "'a'"}


def _misfit(value: object, scalar: Any, *, many: bool = False) -> BadLaunchValueError:
    """Return the error for a value that is not of the type `scalar`; the error's text has an example."""
    example, kind = _EXAMPLES[scalar], scalar.__name__
    if many:
        example, kind = f'[{example}, {example}]', f'list of {kind}'
    return BadLaunchValueError(f'{value!r:.100} is not of the type {kind}; give a value such as {example}')


def _plain(item: object, scalar: Any) -> object:
    if scalar is not None and isinstance(item, SCALARS) and not _is_of(item, (scalar,)):
        raise _misfit(item, scalar)
    if not isinstance(item, SCALARS):
        raise TypeError(f'expected a number, a boolean, a string or a substitution, got {item!r:.200}')
    return item


def perform_typed_substitution(context: LaunchContext, value: Any, data_type: object = None) -> Any:
    """Evaluate a value from normalize_typed_substitution(). Raises ValueError if its type is wrong."""
    if isinstance(value, list) and is_substitution(value):
        return coerce_to_type(perform_substitutions(context, value), data_type)
    if isinstance(value, list):
        item_type = scalar_type(data_type)[0] if data_type is not None else None
        return [
            coerce_to_type(perform_substitutions(context, item), item_type) if is_substitution(item) else item
            for item in value
        ]
    return value


def evaluate_condition_expression(context: LaunchContext, expression: Iterable[Substitution]) -> bool:
    """Return True for true or 1, False for false or 0; raise InvalidConditionExpressionError for others."""
    text = perform_substitutions(context, expression)
    if text.strip().lower() in {'true', '1'}:
        return True
    if text.strip().lower() in {'false', '0'}:
        return False
    raise InvalidConditionExpressionError(
        f"expected a condition to be one of true, false, 1 or 0, but got '{text}'"
    )


def truth(context: LaunchContext, some: SomeSubstitutions) -> bool:
    """Return the boolean that a text stands for, by as_bool(). Raises SubstitutionFailure for other texts."""
    text = perform_text(context, some)
    found = as_bool(text)
    if found is None:
        raise SubstitutionFailure(f"expected true or false, but got '{text}'")
    return found
