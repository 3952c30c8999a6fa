"""Which keys match which: the rules, and the same answers as zenoh's own."""

from __future__ import annotations

import pytest
import zenoh
from hypothesis import given, settings
from hypothesis import strategies as st

from goalwire.zenoh.protocol import key_index, liveliness_tokens
from goalwire.zenoh.protocol.key_expressions import canonical, check, includes, intersects, is_wild
from goalwire.zenoh.protocol.key_index import KeyIndex
from goalwire.zenoh.protocol.liveliness_tokens import Liveliness
from goalwire.zenoh.protocol.primitives import ZenohProtocolError

CHUNKS = st.sampled_from(
    ['a', 'b', 'ab', 'abc', '*', '**', '@a', '@b', 'a$*', '$*b', 'a$*c', '$*b$*', 'a$*b$*c', '$*a$*', 'ba']
)
EXPRESSIONS = st.lists(CHUNKS, min_size=1, max_size=5).map('/'.join)
PLAIN = st.lists(st.sampled_from(['a', 'b', 'ab', 'abc', '@a']), min_size=1, max_size=5).map('/'.join)


@settings(max_examples=400, deadline=None)
@given(EXPRESSIONS, EXPRESSIONS)
def test_the_same_match_as_in_zenoh(one: str, other: str) -> None:
    one, other = canonical(one), canonical(other)
    first, second = zenoh.KeyExpr(one), zenoh.KeyExpr(other)
    assert intersects(one, other) == first.intersects(second)
    assert includes(one, other) == first.includes(second)


@settings(max_examples=200, deadline=None)
@given(EXPRESSIONS)
def test_the_same_canonical_form_as_in_zenoh(expression: str) -> None:
    assert canonical(expression) == str(zenoh.KeyExpr.autocanonize(expression))


@pytest.mark.parametrize(
    ('expression', 'form'),
    [('**/**', '**'), ('**/*', '*/**'), ('a/$*', 'a/*'), ('$*$*', '*'), ('$*$*b', '$*b'), ('a/b', 'a/b')],
)
def test_canonical_forms(expression: str, form: str) -> None:
    assert canonical(expression) == form


@pytest.mark.parametrize(
    'text', ['', '/', '/a', 'a/', 'a//b', 'a#', 'a?b', 'a*', '**a', 'a$b', '$', 'a/***', '$**']
)
def test_what_is_no_key_expression(text: str) -> None:
    with pytest.raises(ZenohProtocolError, match='not a key expression'):
        check(text)


@pytest.mark.parametrize(
    ('one', 'other', 'expected'),
    [
        ('@ros2_lv/0/**', '@ros2_lv/0/1/2', True),
        ('@ros2_lv/0/**', '@ros2_lv/0', True),
        ('@ros2_lv/0/**', '@ros2_lv/1/2', False),
        ('a/**', 'ab', False),
        ('a/**', 'a/@b/c', False),
        ('a/**', 'a/b/@c', False),
        ('**', '@a', False),
        ('@a/**', '@a', True),
    ],
)
def test_wildcards_at_the_end_which_are_nearly_all(one: str, other: str, expected: bool) -> None:
    assert intersects(one, other) is intersects(other, one) is expected


@given(st.lists(EXPRESSIONS.map(canonical), max_size=12), EXPRESSIONS.map(canonical))
def test_an_index_finds_what_a_search_through_all_finds(declared: list[str], key: str) -> None:
    index: KeyIndex[int] = KeyIndex()
    for number, each in enumerate(declared):
        index.add(number, each, number)
    for number in range(0, len(declared), 3):
        assert index.pop(number) == (declared[number], number)
        assert index.pop(number) is None
    expected = [n for n, each in enumerate(declared) if n % 3 and intersects(each, key)]
    assert sorted(thing for _, thing in index.meeting(key)) == expected
    assert index.has_meeting(key) is bool(expected)


@settings(max_examples=400, deadline=None)
@given(st.lists(EXPRESSIONS.map(canonical), max_size=12), st.data())
def test_tokens_are_found_that_a_search_through_all_finds(declared: list[str], data: st.DataObject) -> None:
    tokens = Liveliness(lambda error: None)
    for each in declared:
        tokens.appeared(each)
    gone = data.draw(st.lists(st.sampled_from(declared), unique=True)) if declared else []
    for each in gone:
        for _ in range(declared.count(each)):
            tokens.vanished(each)
    key = data.draw(EXPRESSIONS.map(canonical).filter(is_wild))
    expected = {each for each in declared if each not in gone and intersects(each, key)}
    found = tokens.present(key)
    assert len(found) == len(set(found))
    assert set(found) == expected


def test_one_that_looks_at_a_robot_is_not_compared_with_what_other_robots_have(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    compared: list[tuple[str, str]] = []

    def spy(one: str, other: str) -> bool:
        compared.append((one, other))
        return intersects(one, other)

    monkeypatch.setattr(key_index, 'intersects', spy)
    monkeypatch.setattr(liveliness_tokens, 'intersects', spy)
    tokens = Liveliness(lambda error: None)
    queryables: KeyIndex[int] = KeyIndex()
    for robot in range(100):
        tokens.appeared(f'@ros2_lv/7/{robot:x}/0/1/MP/%/%r{robot}/body/%r{robot}%walk%status')
        tokens.appeared(f'7/r{robot}/walk/status/@adv/pub/{robot:x}/1/_')
        queryables.add(robot, f'7/r{robot}/walk/status/@adv/pub/{robot:x}/1/_', robot)
    assert tokens.present('7/r5/walk/status/@adv/pub/**') == ['7/r5/walk/status/@adv/pub/5/1/_']
    assert [robot for _, robot in queryables.meeting('7/r5/walk/status/@adv/pub/**')] == [5]
    assert len(compared) == 2
