from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.errors import LONGEST_SHOWN, LocalError, point_at
from goalwire.rules.names import (
    InvalidName,
    is_hidden_name,
    validate_enclave,
    validate_full_topic_name,
    validate_namespace,
    validate_node_name,
    validate_topic_name,
)

if TYPE_CHECKING:
    from collections.abc import Callable

NODE_CHARACTERS = "must not contain characters other than alphanumerics or '_'"
FULL_CHARACTERS = "must not contain characters other than alphanumerics, '_', or '/'"
TOPIC_CHARACTERS = "must not contain characters other than alphanumerics, '_', '~', '{', or '}'"
TILDE = "topic name must not have tilde '~' unless it is the first character"
LONE_TILDE = "topic name must not have a tilde '~' that is not followed by a forward slash '/'"
BRACES = "topic name must not have unmatched (unbalanced) curly braces '{}'"


def fault(error: pytest.ExceptionInfo[InvalidName]) -> tuple[str, int]:
    return error.value.reason, error.value.index


@pytest.mark.parametrize(
    ('name', 'reason', 'index'),
    [
        ('', 'node name must not be empty', 0),
        ('a b', f'node name {NODE_CHARACTERS}', 1),
        ('a.b', f'node name {NODE_CHARACTERS}', 1),
        ('/a', f'node name {NODE_CHARACTERS}', 0),
        ('é', f'node name {NODE_CHARACTERS}', 0),
        ('1a', 'node name must not start with a number', 0),
        ('1 a', f'node name {NODE_CHARACTERS}', 1),
        ('x' * 256, "node name length should not exceed '255'", 254),
    ],
)
def test_a_forbidden_node_name_is_told_in_the_words_of_ros_2(name: str, reason: str, index: int) -> None:
    with pytest.raises(InvalidName) as error:
        validate_node_name(name)
    assert fault(error) == (reason, index)


@pytest.mark.parametrize('name', ['a', '_h', 'A1_b', 'x' * 255])
def test_an_allowed_node_name_passes(name: str) -> None:
    validate_node_name(name)


def test_the_text_points_at_the_fault() -> None:
    with pytest.raises(InvalidName) as error:
        validate_node_name('ab-c')
    assert str(error.value) == f"Invalid node name: node name {NODE_CHARACTERS}:\n  'ab-c'\n     ^"
    assert (error.value.kind, error.value.name) == ('node name', 'ab-c')
    assert isinstance(error.value, LocalError)


@pytest.mark.parametrize(
    ('namespace', 'reason', 'index'),
    [
        ('', 'namespace must not be empty', 0),
        ('ok', "namespace must be absolute, it must lead with a '/'", 0),
        ('a/', "namespace must be absolute, it must lead with a '/'", 0),
        ('/ok/', "namespace must not end with a '/', unless only a '/'", 3),
        ('/a//b', "namespace must not contain repeated '/'", 3),
        ('/a b', f'namespace {FULL_CHARACTERS}', 2),
        ('/~/x', f'namespace {FULL_CHARACTERS}', 1),
        ('/1a', 'namespace must not have a token that starts with a number', 1),
        ('/' + 'x' * 245, "namespace should not exceed 'RMW_NAMESPACE_MAX_NAME_LENGTH'", 244),
    ],
)
def test_a_forbidden_namespace_is_told_in_the_words_of_ros_2(namespace: str, reason: str, index: int) -> None:
    with pytest.raises(InvalidName) as error:
        validate_namespace(namespace)
    assert fault(error) == (reason, index)
    assert error.value.kind == 'namespace'


@pytest.mark.parametrize('namespace', ['/', '/a', '/a/_b/c1', '/' + 'x' * 244])
def test_an_allowed_namespace_passes(namespace: str) -> None:
    validate_namespace(namespace)


@pytest.mark.parametrize(
    ('name', 'reason', 'index'),
    [
        ('', 'topic name must not be empty string', 0),
        ('/', 'topic name must not end with a forward slash', 0),
        ('a/', 'topic name must not end with a forward slash', 1),
        ('a b', f'topic name {TOPIC_CHARACTERS}', 1),
        ('1a', 'topic name token must not start with a number', 0),
        ('a/1b', 'topic name token must not start with a number', 2),
        ('a~', TILDE, 1),
        ('{~}', TILDE, 1),
        ('~a/b', LONE_TILDE, 1),
        ('~{node}/a', LONE_TILDE, 1),
        ('a{', BRACES, 1),
        ('a}', BRACES, 1),
        ('b{x}{b', BRACES, 4),
        ('{no de}', f'substitution name {NODE_CHARACTERS}', 3),
        ('{{namespace}', f'substitution name {NODE_CHARACTERS}', 1),
        ('{1a}', 'substitution name must not start with a number', 1),
    ],
)
def test_a_forbidden_topic_name_is_told_in_the_words_of_ros_2(name: str, reason: str, index: int) -> None:
    with pytest.raises(InvalidName) as error:
        validate_topic_name(name)
    assert fault(error) == (reason, index)
    assert error.value.kind == 'topic name'


@pytest.mark.parametrize('name', ['a', '/a/b', '~', '~/a', '{node}/a', 'a{ns}b', 'a//b', '_a', '{}'])
def test_what_users_may_write_passes(name: str) -> None:
    validate_topic_name(name)


def test_a_two_letter_name_after_a_tilde_is_refused_though_rcl_overlooks_it() -> None:
    # rcl's loop stops before the last character and makes /ns/nodeb of ~b.
    with pytest.raises(InvalidName) as error:
        validate_topic_name('~b')
    assert fault(error) == (LONE_TILDE, 1)


def test_a_service_name_is_called_one() -> None:
    with pytest.raises(InvalidName) as relative:
        validate_topic_name('a b', is_service=True)
    with pytest.raises(InvalidName) as full:
        validate_full_topic_name('/a b', is_service=True)
    assert (relative.value.kind, full.value.kind) == ('service name', 'service name')


@pytest.mark.parametrize(
    ('name', 'reason', 'index'),
    [
        ('', 'topic name must not be empty', 0),
        ('ok', "topic name must be absolute, it must lead with a '/'", 0),
        ('/', "topic name must not end with a '/'", 0),
        ('/a/', "topic name must not end with a '/'", 2),
        ('/~', f'topic name {FULL_CHARACTERS}', 1),
        ('/a b', f'topic name {FULL_CHARACTERS}', 2),
        ('/ns/a//b', "topic name must not contain repeated '/'", 6),
        ('/a/1', 'topic name must not have a token that starts with a number', 3),
        ('/' + 'x' * 247, "topic length should not exceed '255U - 8U'", 246),
    ],
)
def test_a_forbidden_full_name_is_told_in_the_words_of_ros_2(name: str, reason: str, index: int) -> None:
    with pytest.raises(InvalidName) as error:
        validate_full_topic_name(name)
    assert fault(error) == (reason, index)


def test_an_enclave_is_judged_like_a_namespace() -> None:
    validate_enclave('/')
    validate_enclave('/a/b')
    with pytest.raises(InvalidName) as error:
        validate_enclave('x')
    assert fault(error) == ("context name must be absolute, it must lead with a '/'", 0)


@pytest.mark.parametrize(
    ('name', 'hidden'), [('/a/_action/status', True), ('_a', True), ('/a_b/c', False), ('/', False)]
)
def test_a_token_with_an_underscore_in_front_hides_a_name(name: str, hidden: bool) -> None:
    assert is_hidden_name(name) is hidden


def index_of_fault(validate: Callable[[str], None], name: str) -> int | None:
    try:
        validate(name)
    except InvalidName as error:
        return error.index
    return None


@given(st.text(alphabet='aZ0_/~{} é.', max_size=12))
def test_any_text_is_allowed_or_refused_with_a_place_inside_it(name: str) -> None:
    for validate in (validate_node_name, validate_namespace, validate_topic_name, validate_full_topic_name):
        assert index_of_fault(validate, name) in {None, 0, *range(len(name))}


@pytest.mark.parametrize(
    ('name', 'index'),
    [
        ('/' + 'x' * 9999, 246),
        (f'/{"x" * 500}-{"y" * 500}', 501),
        ('-' + 'x' * 600, 0),
        ('x' * 600 + '-', 600),
    ],
)
def test_of_a_long_name_the_part_around_the_fault_is_shown(name: str, index: int) -> None:
    text = point_at('topic name', name, 'what is wrong', index)
    said, shown, pointer = text.splitlines()
    assert said == f'Invalid topic name: what is wrong (it has {len(name):,} characters):'
    assert len(shown) <= LONGEST_SHOWN + 6
    assert shown[pointer.index('^')] == name[index]
    with pytest.raises(InvalidName) as caught:
        validate_full_topic_name('/' + 'x' * 100_000)
    assert len(str(caught.value)) < 800
