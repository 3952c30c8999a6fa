"""The six one-function modules about names. The rules themselves are tested with goalwire.rules.names."""

from __future__ import annotations

import pytest
from rclpy.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidParameterException,
    InvalidServiceNameException,
    InvalidTopicNameException,
)
from rclpy.expand_topic_name import expand_topic_name
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name
from rclpy.validate_parameter_name import validate_parameter_name
from rclpy.validate_topic_name import validate_topic_name

NOT_ALPHANUMERIC = "must not contain characters other than alphanumerics or '_'"


def test_names_that_ros_2_allows_return_true() -> None:
    assert validate_node_name('talker')
    assert validate_namespace('/a/b')
    assert validate_topic_name('~/{node}/x')
    assert validate_full_topic_name('/a/b')
    assert validate_parameter_name('a.b')


def test_a_bad_node_name_is_shown_with_the_character() -> None:
    with pytest.raises(InvalidNodeNameException) as caught:
        validate_node_name('a.b')
    assert str(caught.value) == f"Invalid node name: node name {NOT_ALPHANUMERIC}:\n  'a.b'\n    ^"


def test_a_bad_namespace_is_refused() -> None:
    with pytest.raises(InvalidNamespaceException, match="must not contain repeated '/'"):
        validate_namespace('/a//b')


def test_a_bad_topic_name_is_refused() -> None:
    with pytest.raises(InvalidTopicNameException, match='topic name token must not start with a number'):
        validate_topic_name('a/1b')


def test_a_bad_service_name_is_refused_as_one() -> None:
    with pytest.raises(InvalidServiceNameException):
        validate_topic_name('a b', is_service=True)
    with pytest.raises(InvalidServiceNameException):
        validate_full_topic_name('/a b', is_service=True)


def test_a_full_name_must_be_absolute() -> None:
    with pytest.raises(InvalidTopicNameException, match="must be absolute, it must lead with a '/'"):
        validate_full_topic_name('ok')


def test_an_empty_parameter_name_is_refused() -> None:
    with pytest.raises(InvalidParameterException, match='Invalid parameter name: '):
        validate_parameter_name('')


@pytest.mark.parametrize(
    ('name', 'namespace', 'full'),
    [
        ('a', '/ns', '/ns/a'),
        ('/a', '/ns', '/a'),
        ('~/a', '/ns', '/ns/n/a'),
        ('{node}/a', '/ns', '/ns/n/a'),
        ('~/a', '/', '/n/a'),
        ('a//b', '/', '/a//b'),
    ],
)
def test_names_are_expanded(name: str, namespace: str, full: str) -> None:
    assert expand_topic_name(name, 'n', namespace) == full


@pytest.mark.parametrize(
    ('arguments', 'text'),
    [
        (('{bad}', 'n', '/ns'), "topic name '{bad}' is invalid: unknown substitution: {bad}"),
        (
            ('a', 'n', 'ns'),
            "node namespace 'ns' is invalid: namespace must be absolute, it must lead with a '/'",
        ),
        (('', 'n', '/'), "topic name '' is invalid: topic name must not be empty string"),
        (('a', 'n n', '/'), f"node name 'n n' is invalid: node name {NOT_ALPHANUMERIC}"),
    ],
)
def test_what_cannot_be_expanded_is_refused(arguments: tuple[str, str, str], text: str) -> None:
    with pytest.raises(ValueError) as caught:
        expand_topic_name(*arguments)
    assert str(caught.value) == text


@pytest.mark.parametrize(
    ('name', 'hidden'),
    [('_a', True), ('/a/_b', True), ('a/_b/c', True), ('a_', False), ('/a', False), ('', False)],
)
def test_a_token_that_starts_with_an_underscore_hides_a_name(name: str, hidden: bool) -> None:
    assert topic_or_service_is_hidden(name) is hidden
