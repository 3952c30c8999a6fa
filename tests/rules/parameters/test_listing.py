"""Which names a list of parameters holds."""

from __future__ import annotations

from typing import Any

import pytest

from goalwire.rules.parameters.listing import list_names

NAMES = ['i', 'x.y.z', 'x..y', '.lead', 'a.b.c', 'a.b.d', 'a.e']


@pytest.mark.parametrize(
    ('prefixes', 'depth', 'names', 'heads'),
    [
        ([], 0, NAMES, ['x.y', 'x.', '', 'a.b', 'a']),
        ([], 1, ['i'], []),
        ([], 2, ['i', '.lead', 'a.e'], ['', 'a']),
        (['x'], 0, ['x.y.z', 'x..y'], ['x.y', 'x.']),
        (['x'], 1, [], []),
        (['x'], 2, ['x.y.z', 'x..y'], ['x.y', 'x.']),
        (['x.y'], 1, ['x.y.z'], ['x.y']),
        (['a'], 1, ['a.e'], ['a']),
        (['a.b', 'a'], 0, ['a.b.c', 'a.b.d', 'a.e'], ['a.b', 'a']),
        (['i', 'i'], 0, ['i'], []),
        (['a.b.c'], 1, ['a.b.c'], ['a.b']),
        (['nope'], 0, [], []),
        (['x.'], 0, ['x..y'], ['x.']),
    ],
)
def test_names_at_or_below_the_prefixes_are_found(
    prefixes: list[str], depth: int, names: list[str], heads: list[str]
) -> None:
    assert list_names(NAMES, prefixes, depth) == (names, heads)


@pytest.mark.parametrize(
    ('prefixes', 'depth', 'error', 'text'),
    [
        (None, 0, TypeError, 'The prefixes argument must be a list'),
        (('x',), 0, TypeError, 'The prefixes argument must be a list'),
        ([1], 0, TypeError, 'All prefixes must be instances of type str'),
        ([], 1.0, TypeError, 'The depth must be instance of type int'),
        ([], -1, ValueError, 'The depth must be greater than or equal to zero'),
    ],
)
def test_a_question_of_the_wrong_kind_is_refused(
    prefixes: Any, depth: Any, error: type[Exception], text: str
) -> None:
    with pytest.raises(error) as raised:
        list_names(NAMES, prefixes, depth)
    assert str(raised.value) == text
