"""Parses literals in a definition: turns the text of a default or a constant into a Python value.

Each function raises ValueError with a sentence that says what is wrong; the grammar adds file and line.
"""

from __future__ import annotations

import math
import re

from goalwire.idl.model import Default, FieldType, Scalar, Shape, integer_range
from goalwire.patterns import Pattern

BOOLEANS = {'true': True, '1': True, 'false': False, '0': False}
"""The texts of booleans in definitions, in small letters."""
_FLOAT32_MAX = 3.4028235677973366e38  # the least magnitude that rounds to infinity as a float32
_LONGEST_NUMBER = 200  # characters; 64 bits in binary notation need only 67
_ESCAPE = Pattern(r'\\(?:([0-7]{1,3})|x([0-9a-fA-F]{1,2})|u([0-9a-fA-F]{1,4})|(.))')
_LETTER_ESCAPES = {'n': '\n', 't': '\t', 'v': '\v', 'b': '\b', 'r': '\r', 'f': '\f', 'a': '\a'}


def parse_default(text: str, type_: FieldType) -> Default:
    """Parse the default of a field: one value, or [a, b, …] for arrays and sequences."""
    if type_.is_message:
        raise ValueError(f'a field of message type {type_.base} cannot have a default')
    if type_.shape is Shape.SINGLE:
        return parse_scalar(text, type_.base, type_.string_capacity)
    if not (text.startswith('[') and text.endswith(']')):
        raise ValueError(f'the default of an array is written [a, b, …], not {text}')
    values = tuple(parse_scalar(item, type_.base, type_.string_capacity) for item in _split(text[1:-1]))
    if type_.shape is Shape.ARRAY and len(values) != type_.capacity:
        raise ValueError(f'the default has {len(values)} values, the array exactly {type_.capacity}')
    if type_.shape is Shape.BOUNDED and len(values) > type_.capacity:
        raise ValueError(f'the default has {len(values)} values, the sequence at most {type_.capacity}')
    return values


def parse_scalar(text: str, base: str, string_capacity: int = 0) -> Scalar:
    """Parse one value of a primitive type."""
    if base in ('string', 'wstring'):
        return _parse_string(text, string_capacity)
    if base == 'bool':
        if text.lower() not in BOOLEANS:
            raise ValueError(f'{text!r} is not a bool (write true or false)')
        return BOOLEANS[text.lower()]
    if base in ('float32', 'float64'):
        return _parse_float(text, base)
    return _parse_integer(text, base)


def _parse_integer(text: str, base: str) -> int | bytes:
    if len(text) > _LONGEST_NUMBER:  # Python would refuse thousands of digits with another error text
        raise ValueError(f'a number of {len(text)} characters is outside the range of {base}')
    try:
        value = int(text, 0)
    except ValueError:
        try:
            value = int(text, 10)  # base 10 allows leading zeros, base 0 does not
        except ValueError:
            raise ValueError(f'{text!r} is not an integer ({base})') from None
    low, high = integer_range('uint8' if base == 'byte' else base)
    if not low <= value <= high:
        raise ValueError(f'{text} is outside the range of {base}, [{low}, {high}]')
    return bytes((value,)) if base == 'byte' else value


def _parse_float(text: str, base: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f'{text!r} is not a number ({base})') from None
    overflown = math.isinf(value) and any(map(str.isdigit, text))
    if overflown or (base == 'float32' and math.isfinite(value) and abs(value) >= _FLOAT32_MAX):
        raise ValueError(f'{text} is outside the range of {base}')
    return value


def _parse_string(text: str, capacity: int) -> str:
    quote = text[:1]
    if quote in ('"', "'") and quote:
        if len(text) < 2 or closing_quote(text) != len(text) - 1:
            raise ValueError(f'the quotes of {text} do not match')
        text = text[1:-1]
    value = _ESCAPE.sub(_unescape, text)
    if '\0' in value:
        raise ValueError('a string cannot contain a NUL')
    if any('\ud800' <= sign <= '\udfff' for sign in value):
        raise ValueError('half of a surrogate pair is not a character')
    if capacity and len(value) > capacity:
        raise ValueError(f'the string has {len(value)} characters, its type at most {capacity}')
    return value


def _unescape(match: re.Match[str]) -> str:
    octal, hexadecimal, code_point, letter = match.groups()
    if octal:
        return chr(int(octal, 8))
    if hexadecimal or code_point:
        return chr(int(hexadecimal or code_point, 16))
    return _LETTER_ESCAPES.get(letter, letter if letter in '\\?\'"' else match[0])


def closing_quote(text: str, start: int = 0) -> int:
    """Return the index of the quote that closes the quote at text[start]; -1 if none does."""
    at = start + 1
    while at < len(text):
        if text[at] == '\\':
            at += 1
        elif text[at] == text[start]:
            return at
        at += 1
    return -1


def _split(text: str) -> list[str]:
    """Split a text at its commas, except those within quotes."""
    items: list[str] = []
    at, end = 0, len(text)
    while (at := _next_word(text, at)) < end:
        quoted = closing_quote(text, at) if text[at] in '"\'' else at
        if quoted < 0:
            raise ValueError(f'the quotes of {text[at:]} do not match')
        comma = text.find(',', quoted)
        items.append(text[at : comma if comma >= 0 else end].strip())
        if comma < 0:
            break
        at = comma + 1
        if _next_word(text, at) == end:
            raise ValueError('a value is missing after the last comma')
    return items


def _next_word(text: str, at: int) -> int:
    while at < len(text) and text[at].isspace():
        at += 1
    return at
