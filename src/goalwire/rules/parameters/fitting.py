"""Converts a value that a person gives to the declared type of a parameter, or refuses it with an example.

The rule is that of message fields (idl/field_values.py): 1 for a double and 3.0 for an integer are
unambiguous, and accepted; 'fast' for a double, 2.5 for an integer and 'false' for a bool are refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from goalwire.errors import FieldValueError
from goalwire.idl.field_values import Written, fit_value, read_yaml
from goalwire.idl.model import FieldType, Shape
from goalwire.rules.parameters.parameter import ParameterValue, Type

KIND_NAMES = {
    Type.BOOL: 'boolean',
    Type.INTEGER: 'integer',
    Type.DOUBLE: 'double',
    Type.STRING: 'string',
    Type.BYTE_ARRAY: 'byte array',
    Type.BOOL_ARRAY: 'boolean array',
    Type.INTEGER_ARRAY: 'integer array',
    Type.DOUBLE_ARRAY: 'double array',
    Type.STRING_ARRAY: 'string array',
}
"""The names that `ros2 param` gives to the types."""

_FIELD_TYPES = {
    Type.BOOL: FieldType('bool'),
    Type.INTEGER: FieldType('int64'),
    Type.DOUBLE: FieldType('float64'),
    Type.STRING: FieldType('string'),
    Type.BYTE_ARRAY: FieldType('byte', Shape.UNBOUNDED),
    Type.BOOL_ARRAY: FieldType('bool', Shape.UNBOUNDED),
    Type.INTEGER_ARRAY: FieldType('int64', Shape.UNBOUNDED),
    Type.DOUBLE_ARRAY: FieldType('float64', Shape.UNBOUNDED),
    Type.STRING_ARRAY: FieldType('string', Shape.UNBOUNDED),
}


def fit_parameter(name: str, type_: Type, given: object) -> ParameterValue:
    """Return `given`, which `read_yaml` has read, as a value of the declared type `type_` of a parameter.

    Raises FieldValueError, which names the parameter, the type, what was given, and an example.
    """
    try:
        return cast('ParameterValue', fit_value(_FIELD_TYPES[type_], given, name))
    except FieldValueError as error:
        raise FieldValueError(error.path, error.reason, KIND_NAMES[type_]) from None


def fit_parameter_text(name: str, type_: Type, text: str) -> ParameterValue:
    """Return a text from a command line or a form as a value of the declared type of a parameter.

    If the type is string, every text that is not a list is accepted. Raises FieldValueError.
    """
    try:
        given: Any = read_yaml(text)
    except FieldValueError as error:
        if type_ is Type.STRING:
            return text
        raise FieldValueError(name, error.reason, KIND_NAMES[type_]) from None
    if given is None:
        given = Written(text, None)
    is_nothing = isinstance(given, Written) and given.value is None
    if type_ is Type.STRING and (is_nothing or isinstance(given, Mapping)):
        return text  # for example 'null', and 'a: b', which is a text here and not a mapping
    return fit_parameter(name, type_, given)


def explain_misfit(name: str, type_: Type, value: object) -> str:
    """Return advice for a value of a wrong type: which value to give instead; '' if there is no advice.

    If a conversion is enough, the text shows the converted value, since programs must convert it themselves.
    """
    try:
        fitted = fit_parameter(name, type_, value)
    except FieldValueError as error:
        return str(error)
    except KeyError:
        return ''
    return f'{name}: give {fitted!r}, not {value!r} ({KIND_NAMES[type_]})'
