"""Reads the values of `-p name:=value` and parameter files, by the rules of rcl_yaml_param_parser.

These rules differ from PyYAML's: `yes`, `on` and `y` are booleans, `010` is octal, `null`, `~` and dates are
strings, and all elements of a sequence must have the same type.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, cast

from goalwire.rules.names.lexer import RuleSyntaxError

if TYPE_CHECKING:
    from collections.abc import Iterator

    import yaml

    from goalwire.rules.parameters.parameter import ParameterValue

    Scalar = bool | int | float | str

_TRUE = frozenset({'Y', 'y', 'yes', 'Yes', 'YES', 'true', 'True', 'TRUE', 'on', 'On', 'ON'})
_FALSE = frozenset({'N', 'n', 'no', 'No', 'NO', 'false', 'False', 'FALSE', 'off', 'Off', 'OFF'})
_INTEGER = re.compile(r'([+-]?)(?:0[xX]([0-9a-fA-F]+)|0([0-7]*)|([1-9][0-9]*))')
_DECIMAL = re.compile(r'[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?')
_HEXADECIMAL = re.compile(r'[+-]?0[xX](?:[0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)(?:[pP][+-]?[0-9]+)?')
_NAMED = re.compile(r'[+-]?\.?(?:inf|nan)|[+-]?infinity', re.IGNORECASE)
_DIGIT_BUT_ZERO = re.compile(r'[1-9]')
_INT64 = range(-(2**63), 2**63)

# Text that YAML always reads as one plain scalar: it has no indicator, no space and no colon.
_PLAIN = re.compile(r'[A-Za-z0-9_./+~][A-Za-z0-9_./+~=-]*|-[A-Za-z0-9_./+~=]+')

_TYPE_NAMES = {bool: 'bool', int: 'integer', float: 'double', str: 'string'}


def parse_parameter_value(text: str) -> ParameterValue:
    """Return the Python value of YAML `text`; None if it has no value or is an empty sequence.

    Raises RuleSyntaxError with ROS 2's text. PyYAML is imported only if the text needs it.
    """
    if _PLAIN.fullmatch(text):
        return plain_scalar(text)
    import yaml

    if not is_text(text):
        raise RuleSyntaxError('Error parsing an event: the bytes are not UTF-8 text')
    try:
        return _from_events(iter(yaml.parse(text, Loader=yaml.SafeLoader)))
    except yaml.YAMLError as error:
        raise RuleSyntaxError('Error parsing an event') from error


def is_text(argument: str) -> bool:
    """Tell whether an argument was valid UTF-8. Python decodes invalid bytes to lone surrogates (PEP 383)."""
    return not any('\ud800' <= sign <= '\udfff' for sign in argument)


def plain_scalar(text: str) -> Scalar:
    """Return the value of an unquoted scalar: a bool, an int64, a float, or else the text itself."""
    if text in _TRUE:
        return True
    if text in _FALSE:
        return False
    integer = _integer(text)
    return _float(text) if integer is None else integer


def _integer(text: str) -> int | None:
    """Read an integer like C's strtoll with base 0; None if the text is not an integer, or exceeds int64."""
    if not (found := _INTEGER.fullmatch(text)):
        return None
    sign, hexadecimal, octal, decimal = found.groups()
    if hexadecimal:
        value = int(hexadecimal, 16)
    elif decimal:
        value = _read_decimal(decimal)
    else:
        value = int(octal or '0', 8)
    value = -value if sign == '-' else value
    return value if value in _INT64 else None


def _read_decimal(digits: str) -> int:
    # Twenty digits never fit an int64, and int() raises its own error for thousands of digits.
    return int(digits[:20])


def _float(text: str) -> float | str:
    """Read a number like C's strtod; return the text itself if it is not a number or exceeds a double."""
    if _NAMED.fullmatch(text):
        return float(text.replace('.', ''))
    try:
        if _HEXADECIMAL.fullmatch(text):
            value = float.fromhex(text)
        elif _DECIMAL.fullmatch(text):
            value = float(text)
        else:
            return text
    except OverflowError:
        return text
    mantissa = re.split('[eEpP]', text, maxsplit=1)[0]
    underflown = value == 0 and _DIGIT_BUT_ZERO.search(mantissa)
    return text if underflown or value in {float('inf'), float('-inf')} else value


def _from_events(events: Iterator[yaml.Event]) -> ParameterValue:
    import yaml

    value: ParameterValue = None
    for event in events:
        if isinstance(event, yaml.ScalarEvent):
            value = plain_value(event)
        elif isinstance(event, yaml.SequenceStartEvent):
            value = sequence_value(events)
        elif isinstance(event, yaml.MappingStartEvent | yaml.AliasEvent):
            raise RuleSyntaxError('Unknown YAML event')
    return value


def sequence_value(events: Iterator[yaml.Event]) -> ParameterValue:
    """Read a sequence up to its end; return None for an empty sequence. Raises RuleSyntaxError."""
    import yaml

    sequence: list[Scalar] = []
    for event in events:
        if isinstance(event, yaml.SequenceEndEvent):
            break
        if isinstance(event, yaml.ScalarEvent):
            _append(sequence, plain_value(event), line_of(event))
        elif isinstance(event, yaml.SequenceStartEvent):
            raise RuleSyntaxError(f'Sequences of sequences are not parameters, at line {line_of(event)}')
        elif isinstance(event, yaml.AliasEvent):
            raise RuleSyntaxError(f'Will not support aliasing at line {line_of(event)}')
        else:
            raise RuleSyntaxError(f'Mappings in sequences are not parameters, at line {line_of(event)}')
    # An empty sequence has no element that shows its type, so ROS 2 treats it as no value.
    return cast('ParameterValue', sequence or None)


def plain_value(event: yaml.ScalarEvent) -> Scalar:
    """Return the value of a scalar, quoted or not; raises RuleSyntaxError for anything else."""
    quoted = event.style in {"'", '"'}
    if not event.value and not quoted:
        raise RuleSyntaxError(f'No value at line {line_of(event)}')
    if quoted or event.tag == 'tag:yaml.org,2002:str':
        return event.value
    return plain_scalar(event.value)


def _append(sequence: list[Scalar], scalar: Scalar, line: int) -> None:
    if sequence and type(scalar) is not type(sequence[0]):
        found = f"Value type '{_TYPE_NAMES[type(scalar)]}' do not belong at line_num {line}"
        raise RuleSyntaxError(f'Sequence should be of same type. {found}')
    sequence.append(scalar)


def line_of(event: yaml.Event) -> int:
    """Return the line, counted from 1, on which a YAML event begins."""
    return event.start_mark.line + 1 if event.start_mark else 1
