from __future__ import annotations

import pytest

from goalwire.rules.names import InvalidName, absolute_namespace, expand_topic_name, qualify_topic_name


@pytest.mark.parametrize(
    ('name', 'namespace', 'expanded'),
    [
        ('a', '/ns', '/ns/a'),
        ('a', '/', '/a'),
        ('/a', '/ns', '/a'),
        ('~', '/ns', '/ns/n'),
        ('~/a', '/ns', '/ns/n/a'),
        ('~/a', '/', '/n/a'),
        ('{node}/a', '/ns', '/ns/n/a'),
        ('{ns}/a', '/ns', '/ns/a'),
        ('{namespace}', '/ns', '/ns'),
        ('/x/{node}', '/ns', '/x/n'),
        ('a//b', '/', '/a//b'),
    ],
)
def test_a_name_expands_as_its_node_means_it(name: str, namespace: str, expanded: str) -> None:
    assert expand_topic_name(name, 'n', namespace) == expanded


def test_an_unknown_substitution_is_refused() -> None:
    with pytest.raises(InvalidName) as error:
        expand_topic_name('a/{bad}', 'n', '/ns')
    assert (error.value.reason, error.value.index) == ('unknown substitution: {bad}', 2)


@pytest.mark.parametrize(
    ('name', 'node', 'namespace', 'kind'),
    [
        ('a b', 'n n', 'ns', 'topic name'),
        ('a', 'n n', 'ns', 'node name'),
        ('a', 'n', 'ns', 'namespace'),
    ],
)
def test_name_then_node_then_namespace_are_judged(name: str, node: str, namespace: str, kind: str) -> None:
    with pytest.raises(InvalidName) as error:
        expand_topic_name(name, node, namespace)
    assert error.value.kind == kind


def test_a_qualified_name_obeys_the_rules_of_full_names() -> None:
    assert qualify_topic_name('~/a', 'n', '/ns') == '/ns/n/a'
    with pytest.raises(InvalidName, match="repeated '/'") as error:
        qualify_topic_name('a//b', 'n', '/ns', is_service=True)
    assert (error.value.index, error.value.kind) == (6, 'service name')


@pytest.mark.parametrize(('given', 'absolute'), [('', '/'), ('foo', '/foo'), ('/a/b', '/a/b')])
def test_a_namespace_becomes_absolute(given: str, absolute: str) -> None:
    assert absolute_namespace(given) == absolute
