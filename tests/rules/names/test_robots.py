"""Which robot a node belongs to, and which names are a robot's."""

from __future__ import annotations

import pytest

from goalwire.rules.names.robots import check_pattern, name_below, robot_of, view_of


@pytest.mark.parametrize(
    ('namespace', 'robot'), [('/', ''), ('', ''), ('/alpha', 'alpha'), ('/alpha/arm/left', 'alpha')]
)
def test_the_first_part_of_a_namespace_is_the_robot(namespace: str, robot: str) -> None:
    assert robot_of(namespace) == robot


def test_relative_names_are_the_robots_and_absolute_ones_are_not() -> None:
    assert name_below('alpha', 'arm/move') == '/alpha/arm/move'
    assert name_below('alpha', '/tf') == '/tf'


def test_a_view_covers_its_robots_and_their_inner_namespaces() -> None:
    view = view_of(['a*', 'beta'])
    assert [
        view.covers(each) for each in ('/alpha', '/alpha/arm', '/beta', '/beta2', '/', '/gamma/alpha')
    ] == [
        True,
        True,
        True,
        False,
        False,
        False,
    ]


@pytest.mark.parametrize('text', ['', '/', 'a/b', 'a b', 'a[bc]', '1a', 'ä', 'a$b', 'a?'])
def test_what_no_namespace_may_contain_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match='is not a pattern of names of robots'):
        check_pattern(text)


def test_a_name_has_no_asterisk_and_a_pattern_needs_one_only_once() -> None:
    with pytest.raises(ValueError, match='is not a name of a robot'):
        check_pattern('a*', is_name=True)
    assert check_pattern('/a**b/') == 'a*b'
    with pytest.raises(ValueError, match='no robots are named'):
        view_of([])
