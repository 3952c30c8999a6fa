from __future__ import annotations

import re

import pytest

from goalwire.logging.record import LoggingSeverity
from goalwire.rules.arguments import (
    ArgumentError,
    Arguments,
    ParameterFile,
    ParameterOverride,
    UnknownArguments,
    parse_arguments,
)
from goalwire.rules.names import RemapRules


def ros(*arguments: str) -> Arguments:
    return parse_arguments(['program', '--ros-args', *arguments])


@pytest.mark.parametrize(
    ('arguments', 'rest'),
    [
        ([], []),
        (['p', 'a', '--ros-args', '-r', 'x:=y', '--', 'b'], ['p', 'a', 'b']),
        (['p', '--ros-args', '-p', 'a:=1', '--log-level', 'info'], ['p']),
        (['p', 'a', '--ros-args', '-r', 'x:=y', '--', 'b', '--ros-args', '-r', 'c:=d'], ['p', 'a', 'b']),
        (['p', '--', '--ros-args', '-r', 'a:=b'], ['p', '--']),
        (['p', '--ros-args', '--', '--ros-args', '--', 'z'], ['p', 'z']),
        (['p', '-p', 'a', '-r', 'x'], ['p', '-p', 'a', '-r', 'x']),
    ],
)
def test_what_is_not_for_ros_stays(arguments: list[str], rest: list[str]) -> None:
    assert parse_arguments(arguments).rest == tuple(rest)


def test_a_bare_remap_rule_counts_and_is_noted_as_deprecated() -> None:
    arguments = parse_arguments(['a', '-r', 'x:=y'])
    assert arguments.rest == ('a', '-r')
    assert arguments.deprecated == ('x:=y',)
    assert RemapRules(arguments.remaps).topic('/x', 'n', '/') == '/y'


def test_parameters_and_files_keep_their_order() -> None:
    arguments = ros('-p', 'a:=1', '--params-file', 'f.yaml', '--param', 'nn:a:=[x, z]')
    assert arguments.parameters == (
        ParameterOverride('a', 1),
        ParameterFile('f.yaml'),
        ParameterOverride('a', ['x', 'z'], 'nn'),
    )
    assert arguments.params_files == ('f.yaml',)


def test_the_last_override_wins() -> None:
    assert ros('-p', 'a:=1', '-p', 'a:=two').overrides_for('/n') == {'a': 'two'}


def test_an_override_for_one_node_means_the_one_in_the_root_namespace() -> None:
    arguments = ros('-p', 'nn:a:=1', '-p', 'b:=2')
    assert arguments.overrides_for('/nn') == {'a': 1, 'b': 2}
    assert arguments.overrides_for('/x/nn') == {'b': 2}
    assert arguments.overrides_for('/mm') == {'b': 2}


@pytest.mark.parametrize(
    'name', ['a.b.c', 'a/b', '/a', 'a__b', 'qos_overrides./chatter.publisher.depth', 'a/', 'a//b']
)
def test_a_parameter_name_may_hold_dots_and_slashes(name: str) -> None:
    assert ros('-p', f'{name}:=1').overrides_for('/n') == {name: 1}


@pytest.mark.parametrize(
    ('rule', 'error'),
    [
        ('novalue', 'Expected lexeme type (22) not found, search ended at index 7'),
        ('a:=', 'error not set'),
        ('a b:=1', 'Expected lexeme type (22) not found, search ended at index 1'),
        ('/ns/pn:a:=1', 'Expected lexeme type 22, got 5 at index 6'),
        ('/**:a:=1', 'Expected lexeme type 22, got 21 at index 1'),
        ('**:=1', "Wildcard '**' is not implemented"),
        ('a..b:=1', 'Expecting token or wildcard'),
        ('~/a:=1', 'Expecting token or wildcard'),
        ('a:={a: 1}', 'Unknown YAML event'),
    ],
)
def test_a_parameter_rule_that_does_not_parse_is_told_with_both_arguments(rule: str, error: str) -> None:
    with pytest.raises(ArgumentError) as raised:
        ros('-p', rule)
    text, _, hint = str(raised.value).partition('; ')
    assert text == f"Couldn't parse parameter override rule: '-p {rule}'. Error: {error}"
    assert ('write ' in hint) == (not rule.partition(':=')[2])


def test_a_remap_rule_that_does_not_parse_is_told_with_both_arguments() -> None:
    with pytest.raises(ArgumentError) as raised:
        ros('--remap', 'foo:=')
    assert str(raised.value) == (
        "Couldn't parse remap rule: '--remap foo:='. Error: error not set; what stands behind := is missing "
        "(write '--remap foo:=…')"
    )


@pytest.mark.parametrize(
    ('flag', 'complaint'),
    [
        ('-r', '-r flag. No remap rule found.'),
        ('--remap', '--remap flag. No remap rule found.'),
        ('-p', '-p flag. No parameter override rule found.'),
        ('--params-file', '--params-file flag. No file path provided.'),
        ('--log-level', "log level flag: '--log-level'. No log level provided."),
        ('--log-config-file', '--log-config-file flag. No file path provided.'),
        ('--log-file-name', '--log-file-name flag. No string prefix provided.'),
        ('-e', '-e flag. No enclave path provided.'),
    ],
)
def test_a_flag_without_its_value_is_told_so(flag: str, complaint: str) -> None:
    with pytest.raises(ArgumentError) as raised:
        ros(flag)
    assert str(raised.value) == f"Couldn't parse trailing {complaint}"


def test_unknown_ros_arguments_are_named_all_together() -> None:
    with pytest.raises(UnknownArguments) as raised:
        parse_arguments(['p', 'fine', '--ros-args', 'bad', '-r', 'a:=b', '-x', '--', 'fine'])
    assert str(raised.value) == "['bad', '-x']"
    assert raised.value.arguments == ('bad', '-x')


@pytest.mark.parametrize(
    ('text', 'level'),
    [
        ('debug', ('', LoggingSeverity.DEBUG)),
        ('WaRn', ('', LoggingSeverity.WARN)),
        ('rcl.a:=fatal', ('rcl.a', LoggingSeverity.FATAL)),
        ('a b:=info', ('a b', LoggingSeverity.INFO)),
    ],
)
def test_a_log_level_is_for_all_loggers_or_for_one(text: str, level: tuple[str, LoggingSeverity]) -> None:
    assert ros('--log-level', text).log_levels == (level,)


@pytest.mark.parametrize(
    ('text', 'error'),
    [
        ('nope', 'Argument does not use a valid severity level'),
        ('a:=nope', 'Argument does not use a valid severity level'),
        ('a:=', 'Expected lexeme type (18) not found, search ended at index 3'),
        (':=info', 'Argument has an invalid logger item that name is empty'),
    ],
)
def test_a_log_level_that_does_not_parse_is_told_with_both_arguments(text: str, error: str) -> None:
    with pytest.raises(ArgumentError) as raised:
        ros('--log-level', text)
    assert str(raised.value) == f"Couldn't parse log level: '--log-level {text}'. Error: {error}"


def test_the_enclave_must_be_absolute() -> None:
    assert ros('-e', '/a/b').enclave == '/a/b'
    with pytest.raises(ArgumentError) as raised:
        ros('--enclave', 'x')
    assert str(raised.value) == (
        "Enclave name is not valid: 'context name must be absolute, it must lead with a '/''. "
        'Invalid index: 0'
    )


def test_log_outputs_are_switched_on_and_off() -> None:
    arguments = ros('--disable-stdout-logs', '--disable-rosout-logs', '--enable-rosout-logs')
    assert (arguments.stdout_logs, arguments.rosout_logs, arguments.external_lib_logs) == (False, True, True)


def test_what_is_no_string_is_refused() -> None:
    with pytest.raises(TypeError, match='got 1'):
        parse_arguments([1])  # type: ignore[list-item]


@pytest.mark.parametrize(
    ('arguments', 'said'),
    [
        (['-p', 'a=1'], "write '-p a:=1', with :="),
        (['-p', 'n:a=1'], "write '-p n:a:=1', with :="),
        (['--param', 'a = 1'], "write '--param a:=1', with :="),
        (['-p', 'a:1'], "write '-p a:=1', with :="),
        (['-p', 'a'], "write '-p a:=…', with :="),
        (['-p', 'a:='], "what stands behind := is missing (write '-p a:=…')"),
        (['-r', 'chatter=talk'], "write '-r chatter:=talk', with :="),
        (['-r', '__node=me'], "write '-r __node:=me', with :="),
    ],
)
def test_a_rule_without_its_sign_is_shown_with_it(arguments: list[str], said: str) -> None:
    with pytest.raises(ArgumentError, match=re.escape(said)):
        parse_arguments(['--ros-args', *arguments])
