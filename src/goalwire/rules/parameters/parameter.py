"""A parameter: a name, a type and a value (rcl_interfaces/msg/ParameterType)."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from enum import Enum
from typing import TYPE_CHECKING, Generic, NoReturn, TypeAlias

if TYPE_CHECKING:
    from typing import Any

    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import ParameterValue as ParameterValueMessage
    from typing_extensions import TypeVar  # type checkers always find this package

    ValueT_co = TypeVar('ValueT_co', default=Any, covariant=True)
else:
    from typing import TypeVar

    ValueT_co = TypeVar('ValueT_co', covariant=True)

ParameterScalar: TypeAlias = bool | int | float | str
ParameterValue: TypeAlias = (
    ParameterScalar | bytes | list[bytes] | list[bool] | list[int] | list[float] | list[str] | None
)


class Type(Enum):
    """The type of a parameter. The numbers are those of rcl_interfaces/msg/ParameterType."""

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
        """Return the parameter type of a Python value; raises TypeError if no type can hold the value."""
        if value is None:
            return cls.NOT_SET
        for kind, scalar, _ in SCALARS:
            if is_kind(value, kind):
                return scalar
        if isinstance(value, (list, tuple, array)):
            for kind, sequence in _SEQUENCES.items():
                if all(is_kind(element, kind) for element in value):
                    return sequence
            raise _add_advice(
                f"The given value is not a list of one of the allowed types '{value}'.",
                'give all items the same type, such as [1.0, 2.0] and not [1.0, 2]',
            )
        advice = 'a parameter is a bool, int, float or str, bytes, or a list of one of these'
        if isinstance(value, Mapping):
            advice += "; declare a parameter for each item, named with a dot as in 'gains.p'"
        raise _add_advice(f"The given value is not one of the allowed types '{value}'.", advice)

    def check(self, value: object) -> bool:
        """Tell whether `value` may be the value of a parameter of this type."""
        if isinstance(value, (list, tuple, array)) and not value:
            return self in _SEQUENCES.values()
        try:
            return Type.from_parameter_value(value) is self and _fits(value)
        except TypeError:
            return False


SCALARS: tuple[tuple[type, Type, Type], ...] = (
    (bool, Type.BOOL, Type.BOOL_ARRAY),
    (int, Type.INTEGER, Type.INTEGER_ARRAY),
    (float, Type.DOUBLE, Type.DOUBLE_ARRAY),
    (str, Type.STRING, Type.STRING_ARRAY),
)
"""The Python type, the parameter's type for one value, and for several."""
# Keys are the types of the elements. The first entry that fits wins: an empty sequence holds bytes, as in
# rclpy.
_SEQUENCES: dict[type, Type] = {bytes: Type.BYTE_ARRAY} | {kind: several for kind, _, several in SCALARS}


def _add_advice(text: str, advice: str) -> TypeError:
    error = TypeError(text)
    error.add_note(advice)
    return error


def is_kind(value: object, kind: type) -> bool:
    """Tell whether `value` is an instance of `kind`. A bool does not count as an int."""
    return isinstance(value, kind) and not (kind is int and isinstance(value, bool))


def _fits(value: object) -> bool:
    """Tell whether a message can hold a value: integers are int64, elements of byte arrays one byte."""
    if isinstance(value, (list, tuple, array)):
        return all(_fits(element) for element in value)
    if isinstance(value, bytes):
        return len(value) == 1
    return not isinstance(value, int) or value in _INT64


FIELDS = {
    Type.BOOL: 'bool_value',
    Type.INTEGER: 'integer_value',
    Type.DOUBLE: 'double_value',
    Type.STRING: 'string_value',
    Type.BYTE_ARRAY: 'byte_array_value',
    Type.BOOL_ARRAY: 'bool_array_value',
    Type.INTEGER_ARRAY: 'integer_array_value',
    Type.DOUBLE_ARRAY: 'double_array_value',
    Type.STRING_ARRAY: 'string_array_value',
}
"""The field of rcl_interfaces/msg/ParameterValue that holds a value of each type."""


def value_message(type_: Type, value: ParameterValue) -> ParameterValueMessage:
    """Return an rcl_interfaces/msg/ParameterValue."""
    from rcl_interfaces.msg import ParameterValue as ParameterValueMessage

    message = ParameterValueMessage(type=type_.value)
    if type_ in FIELDS:
        setattr(message, FIELDS[type_], value)
    return message


_INT64 = range(-(2**63), 2**63)

_Type: TypeAlias = Type  # inside the class Parameter, `Type` is a class attribute


class Parameter(Generic[ValueT_co]):
    """A parameter: a name, a type and a value. Annotations may be `Parameter[str]`, as in newer rclpy."""

    Type = Type

    def __init__(self, name: str, type_: _Type | None = None, value: ParameterValue = None) -> None:
        """Make a parameter; if no type is given, it has the value's type. Raises TypeError, ValueError."""
        if type_ is None:
            type_ = Type.from_parameter_value(value)
        if not isinstance(type_, Type):
            raise TypeError(f"type must be an instance of '{Type!r}'")
        if not type_.check(value):
            raise ValueError(f"Type '{type_}' and value '{value!s}' do not agree")
        self._name = name
        self._type = type_
        self._value: Any = value

    @property
    def name(self) -> str:
        """The parameter's name."""
        return self._name

    @property
    def type_(self) -> _Type:
        """The type of the parameter's value."""
        return self._type

    @property
    def value(self) -> ValueT_co:
        """The parameter's value; None if it has none."""
        found: ValueT_co = self._value
        return found

    @classmethod
    def from_parameter_msg(cls, param_msg: ParameterMessage) -> Parameter:
        """Make a parameter from an rcl_interfaces/msg/Parameter; raises ValueError for an unknown type."""
        value = param_msg.value
        try:
            type_ = Type(value.type)
        except ValueError:
            raise ValueError(
                f"parameter '{param_msg.name}': {value.type} is not a valid Parameter.Type"
            ) from None
        return cls(param_msg.name, type_, getattr(value, FIELDS[type_]) if type_ in FIELDS else None)

    def to_parameter_msg(self) -> ParameterMessage:
        """Return the parameter as an rcl_interfaces/msg/Parameter."""
        from rcl_interfaces.msg import Parameter as ParameterMessage

        return ParameterMessage(name=self._name, value=self.get_parameter_value())

    def get_parameter_value(self) -> ParameterValueMessage:
        """Return the value as an rcl_interfaces/msg/ParameterValue."""
        return value_message(self._type, self._value)

    if not TYPE_CHECKING:  # type checkers find the mistake without this method

        def _refuse_operator(self, _other: object) -> NoReturn:
            """Raise TypeError for every operator, since the program confuses the parameter with its value."""
            raise TypeError(
                f"this is the parameter '{self._name}' and not its value: write "
                f'get_parameter({self._name!r}).value'
            )

        __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = (
            _refuse_operator
        )
        __lt__ = __le__ = __gt__ = __ge__ = _refuse_operator

    def __repr__(self) -> str:
        return f'Parameter(name={self._name!r}, type_={self._type}, value={self._value!r})'
