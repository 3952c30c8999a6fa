"""The substitutions of the package launch that are conditions, compare texts, or choose by a condition."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

from goalwire.errors import BadLaunchValueError
from goalwire.launching.exposure import expose_substitution
from goalwire.launching.model import LaunchContext, SomeSubstitutions, Substitution
from goalwire.launching.substitutions import CompoundSubstitution
from goalwire.launching.values import is_substitution, perform_text, truth

__all__ = [
    'AllSubstitution',
    'AndSubstitution',
    'AnySubstitution',
    'BooleanSubstitution',
    'EqualsSubstitution',
    'IfElseSubstitution',
    'NotEqualsSubstitution',
    'NotSubstitution',
    'OrSubstitution',
]


def _word(value: bool) -> str:
    return 'true' if value else 'false'


class BooleanSubstitution(CompoundSubstitution):
    """`true` or `false`, from a text that stands for a boolean."""

    names = ('value',)

    def __init__(self, value: SomeSubstitutions) -> None:
        super().__init__(value)

    @property
    def value(self) -> list[Substitution]:
        return self._parts[0]

    def perform(self, context: LaunchContext) -> str:
        return _word(truth(context, self._parts[0]))


@expose_substitution('not')
class NotSubstitution(BooleanSubstitution):
    """The opposite of a condition."""

    def perform(self, context: LaunchContext) -> str:
        return _word(not truth(context, self._parts[0]))


class _LeftRight(CompoundSubstitution):
    names = ('left', 'right')
    combine: ClassVar[Callable[[bool, bool], bool]]

    def __init__(self, left: SomeSubstitutions, right: SomeSubstitutions) -> None:
        super().__init__(left, right)

    @property
    def left(self) -> list[Substitution]:
        return self._parts[0]

    @property
    def right(self) -> list[Substitution]:
        return self._parts[1]


@expose_substitution('and')
class AndSubstitution(_LeftRight):
    """True if both conditions are true."""

    def perform(self, context: LaunchContext) -> str:
        return _word(truth(context, self.left) & truth(context, self.right))


@expose_substitution('or')
class OrSubstitution(_LeftRight):
    """True if one of the two conditions is true."""

    def perform(self, context: LaunchContext) -> str:
        return _word(truth(context, self.left) | truth(context, self.right))


@expose_substitution('any')
class AnySubstitution(CompoundSubstitution):
    """True if one of several conditions is true."""

    @classmethod
    def parse(cls, data: Sequence[SomeSubstitutions]) -> tuple[type[Substitution], dict[str, Any]]:
        return cls, {'args': data}

    def perform(self, context: LaunchContext) -> str:
        found = [truth(context, part) for part in self._parts]  # evaluates all conditions, as launch does
        return _word(any(found))


@expose_substitution('all')
class AllSubstitution(AnySubstitution):
    """True if all of several conditions are true."""

    def perform(self, context: LaunchContext) -> str:
        found = [truth(context, part) for part in self._parts]
        return _word(all(found))


@expose_substitution('equals')
class EqualsSubstitution(_LeftRight):
    """True if two texts are equal, or stand for the same number or boolean."""

    def __init__(self, left: Any, right: Any) -> None:
        super().__init__(_as_text(left), _as_text(right))

    def perform(self, context: LaunchContext) -> str:
        return _word(_same(perform_text(context, self.left), perform_text(context, self.right)))


@expose_substitution('not-equals')
class NotEqualsSubstitution(EqualsSubstitution):
    """True if two texts differ."""

    def perform(self, context: LaunchContext) -> str:
        return _word(not _same(perform_text(context, self.left), perform_text(context, self.right)))


def _as_text(value: Any) -> SomeSubstitutions:
    if value is None:
        return ''
    if isinstance(value, bool | int | float):
        return str(value).lower()
    if is_substitution(value) or isinstance(value, Substitution | str):
        return value  # type: ignore[no-any-return]
    return [_as_text(item) for item in value]  # type: ignore[misc]


def _same(left: str, right: str) -> bool:
    """Compare two texts: as booleans if both are true, false, 1 or 0, else as numbers, else as texts."""
    words = {'true': True, '1': True, 'false': False, '0': False}
    booleans = words.get(left.lower()), words.get(right.lower())
    if None not in booleans:
        return booleans[0] == booleans[1]
    try:
        return math.isclose(float(left), float(right))
    except ValueError:
        return left == right


@expose_substitution('if')
class IfElseSubstitution(CompoundSubstitution):
    """One of two texts, chosen by a condition."""

    names = ('condition', 'if_value', 'else_value')
    least = 2

    def __init__(
        self,
        condition: SomeSubstitutions,
        if_value: SomeSubstitutions = '',
        else_value: SomeSubstitutions = '',
    ) -> None:
        super().__init__(condition, if_value, else_value)
        if if_value == else_value == '':
            raise BadLaunchValueError('IfElseSubstitution needs if_value or else_value: both are missing')

    def perform(self, context: LaunchContext) -> str:
        return self._text(context, 1 if truth(context, self._parts[0]) else 2)
