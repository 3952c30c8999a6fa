"""Values for parameters whose type is declared."""

from __future__ import annotations

import pytest

from goalwire.errors import FieldValueError
from goalwire.rules.parameters import Type
from goalwire.rules.parameters.fitting import explain_misfit, fit_parameter_text


@pytest.mark.parametrize(
    ('type_', 'text', 'value'),
    [
        (Type.DOUBLE, '2', 2.0),
        (Type.DOUBLE, '1e-3', 0.001),
        (Type.DOUBLE, '.inf', float('inf')),
        (Type.INTEGER, '4.0', 4),
        (Type.BOOL, 'off', False),
        (Type.BOOL, '1', True),
        (Type.STRING, '005', '005'),
        (Type.STRING, 'on', 'on'),
        (Type.STRING, 'null', 'null'),
        (Type.STRING, 'a: b', 'a: b'),
        (Type.STRING, '{a: [', '{a: ['),
        (Type.STRING, '"7"', '7'),
        (Type.STRING, '', ''),
        (Type.DOUBLE_ARRAY, '[1, 2.5]', [1.0, 2.5]),
        (Type.STRING_ARRAY, '[1, on]', ['1', 'on']),
        (Type.BYTE_ARRAY, '[1, 255]', [b'\x01', b'\xff']),
        (Type.BYTE_ARRAY, "!!binary 'AQI='", [b'\x01', b'\x02']),
        (Type.INTEGER_ARRAY, '[]', []),
    ],
)
def test_what_cannot_be_misunderstood_is_taken(type_: Type, text: str, value: object) -> None:
    fitted = fit_parameter_text('p', type_, text)
    assert fitted == value
    assert type_.check(fitted)


@pytest.mark.parametrize(
    ('type_', 'text', 'problem'),
    [
        (Type.DOUBLE, 'fast', "p: give a number such as 1.5, not 'fast' (double)"),
        (Type.DOUBLE, 'true', 'p: give a number such as 1.5, not true (double)'),
        (Type.DOUBLE, '[1.0]', 'p: give a number such as 1.5, not [1.0] (double)'),
        (Type.DOUBLE, '', 'p: give a number such as 1.5, not nothing (double)'),
        (Type.DOUBLE, 'null', 'p: give a number such as 1.5, not null (double)'),
        (Type.DOUBLE, '2001-13-77', 'p: give a number such as 1.5, not 2001-13-77 (double)'),
        (Type.INTEGER, '2.5', 'p: give a whole number such as 3, not 2.5 (integer)'),
        (Type.INTEGER, '.nan', 'p: give a whole number such as 3, not .nan (integer)'),
        (
            Type.INTEGER,
            '9223372036854775808',
            'p: give a number from -9223372036854775808 to 9223372036854775807, not 92233720368547',
        ),
        (Type.BOOL, '2', 'p: give true or false, not 2 (boolean)'),
        (Type.BOOL, 'flase', "p: give true or false, not 'flase' (boolean)"),
        (Type.STRING, '[1, 2]', "p: give a text such as 'a', not [1, 2] (string)"),
        (Type.INTEGER_ARRAY, '3', 'p: give a list such as [1, 1], not 3 (integer array)'),
        (Type.INTEGER_ARRAY, '{a: 1}', "p: give a list such as [1, 1], not {'a': 1} (integer array)"),
        (Type.DOUBLE_ARRAY, '[[1.0]]', 'p[0]: give a number such as 1.5, not [1.0] (double array)'),
        (Type.STRING_ARRAY, 'left', "p: give a list such as [left], not 'left' (string array)"),
        (Type.STRING_ARRAY, '[a, [b]]', "p[1]: give a text such as 'a', not ['b'] (string array)"),
        (Type.BYTE_ARRAY, '[256]', 'p[0]: give a number from 0 to 255, not 256 (byte array)'),
        (Type.BOOL_ARRAY, '{a: [', 'p: that is not YAML: '),
        (Type.BOOL_ARRAY, '&a [*a]', 'p: that is nested too deeply (boolean array)'),
        (Type.BOOL_ARRAY, '!!python/name:a', 'p: that is not YAML: could not determine a constructor'),
    ],
)
def test_what_does_not_fit_is_refused_with_name_type_and_example(
    type_: Type, text: str, problem: str
) -> None:
    with pytest.raises(FieldValueError) as caught:
        fit_parameter_text('p', type_, text)
    assert str(caught.value).startswith(problem)


@pytest.mark.parametrize(
    ('type_', 'value', 'note'),
    [
        (Type.DOUBLE, 1, 'p: give 1.0, not 1 (double)'),
        (Type.DOUBLE, 'x', "p: give a number such as 1.5, not 'x' (double)"),
        (Type.DOUBLE_ARRAY, [1, 2], 'p: give [1.0, 2.0], not [1, 2] (double array)'),
        (Type.BOOL, 1, 'p: give True, not 1 (boolean)'),
        (Type.STRING, 1, 'p: give a text such as "1", in quotes, not 1 (string)'),
        (Type.INTEGER, [1], 'p: give a whole number such as 3, not [1] (integer)'),
        (Type.NOT_SET, 1, ''),
    ],
)
def test_an_override_of_another_type_is_explained(type_: Type, value: object, note: str) -> None:
    assert explain_misfit('p', type_, value) == note
