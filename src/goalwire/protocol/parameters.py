"""Parameters: typed values under a name, and how they change (rcl_interfaces/msg/ParameterType)."""

from __future__ import annotations

from array import array
from enum import Enum
from typing import TypeAlias

ParameterScalar: TypeAlias = bool | int | float | str
ParameterValue: TypeAlias = (
    ParameterScalar | bytes | list[bytes] | list[bool] | list[int] | list[float] | list[str] | None
)


class Type(Enum):
    """A parameter's type; numbers as in rcl_interfaces/msg/ParameterType."""

    NOT_SET = 0
    BOOL = 1
    INTEGER = 2
    DOUBLE = 3
    STRING = 4
    BYTE_ARRAY = 5
    BOOL_ARRAY = 6
    INTEGER_ARRAY = 7
    DOUBLE_ARRAY = 8
    STRING_ARRAY = 9

    @classmethod
    def from_parameter_value(cls, value: object) -> Type:
        """Return the type that a Python value has; raises TypeError where it has none."""
        if value is None:
            return cls.NOT_SET
        for kind, scalar, _ in _KINDS:
            if scalar is not None and _is(value, kind):
                return scalar
        if isinstance(value, (list, tuple, array)):
            for kind, _, sequence in _KINDS:
                if all(_is(element, kind) for element in value):
                    return sequence
            raise TypeError(f"The given value is not a list of one of the allowed types '{value}'.")
        raise TypeError(f"The given value is not one of the allowed types '{value!r}'.")

    def check(self, value: object) -> bool:
        """True where `value` may be a parameter of this type."""
        if isinstance(value, (list, tuple, array)) and not value:
            return self in _SEQUENCES
        try:
            return Type.from_parameter_value(value) is self
        except TypeError:
            return False


# The Python type of an element, the type of one, the type of several: the first that fits wins.
_KINDS: tuple[tuple[type, Type | None, Type], ...] = (
    (bytes, None, Type.BYTE_ARRAY),
    (bool, Type.BOOL, Type.BOOL_ARRAY),
    (int, Type.INTEGER, Type.INTEGER_ARRAY),
    (float, Type.DOUBLE, Type.DOUBLE_ARRAY),
    (str, Type.STRING, Type.STRING_ARRAY),
)
_SEQUENCES = frozenset(sequence for _, _, sequence in _KINDS)


def _is(value: object, kind: type) -> bool:
    return isinstance(value, kind) and not (kind is int and isinstance(value, bool))


_Type: TypeAlias = Type  # inside Parameter the name is an attribute


class Parameter:
    """A name, a type and a value."""

    Type = Type

    def __init__(self, name: str, type_: _Type | None = None, value: ParameterValue = None) -> None:
        """Take the type from the value where none is given; raises TypeError, ValueError for a mismatch."""
        if type_ is None:
            type_ = Type.from_parameter_value(value)
        if not isinstance(type_, Type):
            raise TypeError(f"type must be an instance of '{Type!r}'")
        if not type_.check(value):
            raise ValueError(f"Type '{type_}' and value '{value!s}' do not agree")
        self._name = name
        self._type = type_
        self._value = value

    @property
    def name(self) -> str:
        """Its name."""
        return self._name

    @property
    def type_(self) -> _Type:
        """Its type."""
        return self._type

    @property
    def value(self) -> ParameterValue:
        """Its value, None where it has none."""
        return self._value

    def __repr__(self) -> str:
        return f'Parameter(name={self._name!r}, type_={self._type}, value={self._value!r})'


class ParameterTable:
    """The declared parameters of one node, and the overrides that wait for their declaration."""

    def __init__(self, overrides: dict[str, ParameterValue], *, allow_undeclared: bool = False) -> None:
        self.allow_undeclared = allow_undeclared
        self.overrides = overrides
        self._declared: dict[str, Parameter] = {}
        self._types: dict[str, Type] = {}
        self._dynamic: set[str] = set()

    def __contains__(self, name: str) -> bool:
        return name in self._declared

    def names(self) -> list[str]:
        """Return the declared names, in order of declaration."""
        return list(self._declared)

    def get(self, name: str) -> Parameter | None:
        """Return a declared parameter, or None."""
        return self._declared.get(name)

    def declare(
        self,
        name: str,
        default: Parameter,
        expected: Type,
        *,
        ignore_override: bool = False,
        dynamic: bool = False,
    ) -> None:
        """Declare; an override wins over the default. `expected` is the type it keeps, unless dynamic."""
        value = default
        if not ignore_override and name in self.overrides:
            value = Parameter(name, value=self.overrides[name])
        self._declared[name] = value
        self._types[name] = value.type_ if expected is Type.NOT_SET else expected
        if dynamic:
            self._dynamic.add(name)

    def is_static(self, name: str) -> bool:
        """True where the parameter keeps the type it was declared with."""
        return self._types.get(name, Type.NOT_SET) is not Type.NOT_SET and name not in self._dynamic

    def refusal(self, parameter: Parameter) -> str:
        """Return '' where the parameter may be set now, else ROS 2's reason why not."""
        expected = self._types.get(parameter.name)
        if expected is None:
            if self.allow_undeclared:
                return ''
            return f'Invalid access to undeclared parameter(s): {parameter.name}'
        if parameter.name in self._dynamic or expected is Type.NOT_SET or parameter.type_ is expected:
            return ''
        return f"Wrong parameter type, expected '{expected}' got '{parameter.type_}'"

    def set(self, parameter: Parameter) -> None:
        """Store a parameter that `refusal` has let pass."""
        self._declared[parameter.name] = parameter
        self._types.setdefault(parameter.name, parameter.type_)

    def undeclare(self, name: str) -> None:
        """Forget a declared parameter."""
        del self._declared[name]
        self._types.pop(name, None)
        self._dynamic.discard(name)
