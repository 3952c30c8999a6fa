from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.rules.names import RemapRules, RuleSyntaxError, parse_remap_rule


def outcome(*texts: str, node: str = 'nn') -> tuple[str, str, str, str]:
    """Remap what every test looks at: the node, a topic, a private topic, a service."""
    rules = RemapRules(map(parse_remap_rule, texts))
    name = rules.node_name(node)
    namespace = rules.namespace('/', name)
    prefix = namespace.rstrip('/')
    return (
        f'{prefix}/{name}',
        rules.topic(f'{prefix}/topic', name, namespace),
        rules.topic(f'{prefix}/{name}/topic', name, namespace),
        rules.service(f'{prefix}/srv', name, namespace),
    )


@pytest.mark.parametrize(
    ('rules', 'expected'),
    [
        ([], ('/nn', '/topic', '/nn/topic', '/srv')),
        (['__ns:=/x'], ('/x/nn', '/x/topic', '/x/nn/topic', '/x/srv')),
        (['__node:=z'], ('/z', '/topic', '/z/topic', '/srv')),
        (['__name:=z'], ('/z', '/topic', '/z/topic', '/srv')),
        (['topic:=/t2'], ('/nn', '/t2', '/nn/topic', '/srv')),
        (['~/topic:=rel'], ('/nn', '/topic', '/rel', '/srv')),
        (['topic:=~/x'], ('/nn', '/nn/x', '/nn/topic', '/srv')),
        (['/topic:=/abs'], ('/nn', '/abs', '/nn/topic', '/srv')),
        (['srv:=s2'], ('/nn', '/topic', '/nn/topic', '/s2')),
        (['nn:topic:=only'], ('/nn', '/only', '/nn/topic', '/srv')),
        (['zz:topic:=only'], ('/nn', '/topic', '/nn/topic', '/srv')),
        (['nn:__node:=z', 'zz:__ns:=/q'], ('/z', '/topic', '/z/topic', '/srv')),
    ],
)
def test_a_rule_renames_as_in_ros_2(rules: list[str], expected: tuple[str, ...]) -> None:
    assert outcome(*rules) == expected


def test_a_scheme_narrows_a_rule_to_topics_or_services() -> None:
    assert outcome('rosservice://srv:=s2', 'rostopic://topic:=t3') == ('/nn', '/t3', '/nn/topic', '/s2')
    assert outcome('rosservice://topic:=t', 'rostopic://srv:=s') == outcome()


def test_the_first_rule_that_matches_wins_and_is_not_followed_by_another() -> None:
    assert outcome('topic:=a', 'topic:=b')[1] == '/a'
    assert outcome('topic:=srv', 'srv:=c')[1] == '/srv'
    assert outcome('__node:=a', '__name:=b')[0] == '/a'


def test_rules_for_one_node_know_it_by_its_new_name_except_the_one_that_names_it() -> None:
    assert outcome('__node:=zz', 'nn:__ns:=/w', 'zz:__ns:=/q')[0] == '/q/zz'
    assert outcome('__node:=zz', 'nn:topic:=/w', 'zz:topic:=/q')[1] == '/q'
    assert outcome('nn:__node:=a', 'a:__node:=b')[0] == '/a'


def test_relative_rules_are_read_in_the_new_namespace() -> None:
    assert outcome('__ns:=/q', 'topic:=w')[1] == '/q/w'
    assert outcome('__ns:=/q', '/topic:=w')[1] == '/q/topic'
    assert outcome('/q/topic:=w', '__ns:=/q')[1] == '/q/w'


@pytest.mark.parametrize(
    ('text', 'error'),
    [
        ('foo', 'Expected lexeme type (19) not found, search ended at index 3'),
        ('foo:=', 'error not set'),
        (':=x', 'Expecting token or wildcard'),
        ('', 'Expecting token or wildcard'),
        ('~:=x', 'Expecting token or wildcard'),
        ('nn::=x', 'Expecting token or wildcard'),
        ('topic=x', 'Expected lexeme type (19) not found, search ended at index 5'),
        ('topic:=a//b', 'error not set'),
        ('topic:=bad name', 'Expected lexeme type (19) not found, search ended at index 10'),
        ('topic:=a__b', 'Expected lexeme type 19, got 18 at index 9'),
        ('topic:=x:=y', 'Expected lexeme type 19, got 8 at index 8'),
        ('/nn:topic:=y', 'Expected lexeme type 19, got 5 at index 3'),
        ('topic:=\\1', 'Backreferences are not implemented'),
        ('*:=x', "Wildcard '*' is not implemented"),
        ('/**/topic:=x', "Wildcard '**' is not implemented"),
        ('__ns:=x', 'Expected lexeme type 19, got 18 at index 6'),
        ('__ns:=/a//b', 'Expected lexeme type 1, got 19 at index 9'),
        ('__ns:=~/a', 'Expected lexeme type 19, got 2 at index 6'),
        ('__node:=a b', 'Expected lexeme type (1) not found, search ended at index 9'),
        ('__node:=z/y', 'Expected lexeme type 1, got 19 at index 9'),
        ('__node:=', 'Expected lexeme type (18) not found, search ended at index 8'),
        ('__node:=__ns', 'Expected lexeme type 18, got 7 at index 8'),
    ],
)
def test_a_rule_that_does_not_parse_is_told_in_the_words_of_ros_2(text: str, error: str) -> None:
    with pytest.raises(RuleSyntaxError) as raised:
        parse_remap_rule(text)
    assert str(raised.value) == error


@given(st.text(alphabet='ab_/~:=*. \\1', max_size=14))
def test_any_text_is_a_rule_or_refused(text: str) -> None:
    try:
        rule = parse_remap_rule(text)
    except RuleSyntaxError:
        return
    assert rule.replacement
    assert rule.replacement in text
