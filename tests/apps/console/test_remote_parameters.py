"""What the console's form takes for a parameter."""

from __future__ import annotations

import pytest

from goalwire.apps.console.remote_parameters import RemoteParameter, fitted_value
from goalwire.errors import FieldValueError

BOOL, INTEGER, DOUBLE, STRING, BYTES, INTEGERS = 1, 2, 3, 4, 5, 7


@pytest.mark.parametrize(
    ('number', 'typed', 'value'),
    [
        (BOOL, True, True),
        (INTEGER, '4', 4),
        (DOUBLE, '2', 2.0),
        (STRING, '[a', '[a'),
        (STRING, '[1, 2]', '[1, 2]'),
        (STRING, None, ''),
        (BYTES, '[1, 255]', [b'\x01', b'\xff']),
        (INTEGERS, '[1, 2]', [1, 2]),
    ],
)
def test_what_fits_is_taken(number: int, typed: object, value: object) -> None:
    assert fitted_value(RemoteParameter('p', number, None), typed) == value


@pytest.mark.parametrize(
    ('number', 'typed', 'problem'),
    [
        (INTEGER, '2.5', 'p: give a whole number such as 3, not 2.5 (integer)'),
        (INTEGER, None, 'p: give a whole number such as 3, not null (integer)'),
        (DOUBLE, 'fast', "p: give a number such as 1.5, not 'fast' (double)"),
        (DOUBLE, '.nan', 'p: give a number from 0 to 1, not nan (double)'),
        (DOUBLE, '2', 'p: give a number from 0 to 1, not 2 (double)'),
        (INTEGERS, '1, 2', "p: give a list such as [1, 1], not '1, 2' (integer array)"),
        (BYTES, '[256]', 'p[0]: give a number from 0 to 255, not 256 (byte array)'),
        (INTEGERS, '[', 'p: that is no YAML: '),
        (0, '1', 'p: it is not set, and so has no type'),
    ],
)
def test_what_does_not_fit_is_refused_with_an_example(number: int, typed: object, problem: str) -> None:
    with pytest.raises(FieldValueError) as caught:
        fitted_value(RemoteParameter('p', number, None, least=0.0, most=1.0), typed)
    assert str(caught.value).startswith(problem)
