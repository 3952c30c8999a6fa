"""Parameters of a node: declared, overridden by arguments and files, read and set."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from rclpy.context import Context
from rclpy.exceptions import (
    InvalidParameterException,
    InvalidParameterTypeException,
    ParameterAlreadyDeclaredException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from goalwire.entities.exceptions import RCLError

Started: TypeAlias = Callable[..., Node]


@pytest.fixture
def started(isolated: dict[str, str]) -> Iterator[Started]:
    """Make a node '/ns/nn' of a process with such ROS arguments."""
    contexts: list[Context] = []

    def start(*arguments: str, **options: Any) -> Node:
        contexts.append(Context())
        contexts[-1].init(args=['--ros-args', *arguments])
        options.setdefault('namespace', 'ns')
        return Node('nn', context=contexts[-1], **options)

    yield start
    for context in contexts:
        context.try_shutdown()


@pytest.fixture
def node(started: Started) -> Node:
    return started()


@pytest.mark.parametrize(
    'value', [True, 1, 1.5, 'text', [b'a'], [True, False], [1, 2], [1.0], ['x', 'y']], ids=repr
)
def test_a_parameter_is_declared_with_its_default(node: Node, value: Any) -> None:
    declared = node.declare_parameter('x', value)
    assert (declared.name, declared.value) == ('x', value)
    assert declared.type_ is Parameter.Type.from_parameter_value(value)
    assert node.get_parameter('x').value == value
    assert node.has_parameter('x')


@pytest.mark.parametrize(
    ('argument', 'default', 'value'),
    [
        ('x:=5', 1, 5),
        ('x:=2.5', 1.0, 2.5),
        ('x:=true', False, True),
        ('x:=text', '', 'text'),
        ('x:="5"', '', '5'),
        ('x:=[1, 2]', [0], [1, 2]),
        ('other:x:=6', 1, 1),
    ],
)
def test_an_argument_wins_over_the_default(started: Started, argument: str, default: Any, value: Any) -> None:
    assert started('-p', argument).declare_parameter('x', default).value == value


def test_an_argument_may_name_its_node(started: Started) -> None:
    assert started('-p', 'nn:x:=6', namespace='/').declare_parameter('x', 1).value == 6


def test_the_node_s_own_arguments_win_over_the_process_s(started: Started) -> None:
    node = started('-p', 'x:=1', '-p', 'y:=1', cli_args=['--ros-args', '-p', 'x:=2'])
    assert node.declare_parameter('x', 0).value == 2
    assert node.declare_parameter('y', 0).value == 1


def test_overrides_of_the_constructor_win_over_arguments(started: Started) -> None:
    node = started('-p', 'x:=1', parameter_overrides=[Parameter('x', value=3)])
    assert node.declare_parameter('x', 0).value == 3
    assert node.declare_parameter('z', 7, ignore_override=True).value == 7


def test_overrides_are_declared_on_demand(started: Started) -> None:
    node = started('-p', 'a.b:=1', automatically_declare_parameters_from_overrides=True)
    assert node.get_parameter('a.b').value == 1
    assert not started('-p', 'a.b:=1').has_parameter('a.b')


def test_a_file_gives_values_to_its_nodes(started: Started, tmp_path: Path) -> None:
    file = tmp_path / 'params.yaml'
    file.write_text(
        '/**:\n  ros__parameters:\n    x: 1\n    deep: {er: two}\n'
        '/ns/nn:\n  ros__parameters: {y: [1.5, 2.5]}\n'
        'ns:\n  nn:\n    ros__parameters: {z: 3}\n'
        '/other:\n  ros__parameters: {x: 9}\n'
    )
    node = started('--params-file', str(file))
    assert node.declare_parameter('x', 0).value == 1
    assert node.declare_parameter('deep.er', '').value == 'two'
    assert node.declare_parameter('y', [0.0]).value == [1.5, 2.5]
    assert node.declare_parameter('z', 0).value == 3


def test_a_file_that_is_not_there_is_named(started: Started, tmp_path: Path) -> None:
    missing = tmp_path / 'missing.yaml'
    with pytest.raises(RCLError, match=rf"^failed to initialize rcl: Couldn't parse params file.*{missing}"):
        started('--params-file', str(missing))


@pytest.mark.parametrize('text', ['[1, 2', 'just text', 'nn:\n  ros__parameters: 5\n'])
def test_a_file_that_makes_no_sense_is_named(started: Started, tmp_path: Path, text: str) -> None:
    file = tmp_path / 'bad.yaml'
    file.write_text(text)
    with pytest.raises(RCLError, match=f"Couldn't parse params file.*{file}"):
        started('--params-file', str(file))


def test_an_override_of_another_type_is_refused(started: Started) -> None:
    node = started('-p', 'x:=text')
    with pytest.raises(InvalidParameterTypeException, match=r"'x'.*'STRING'.*expecting type 'INTEGER'"):
        node.declare_parameter('x', 1)


def test_a_declaration_that_makes_no_sense_is_refused(node: Node) -> None:
    node.declare_parameter('x', 1)
    with pytest.raises(ParameterAlreadyDeclaredException, match=r"^Parameter\(s\) already declared: \['x'\]"):
        node.declare_parameter('x', 2)
    with pytest.raises(InvalidParameterException, match=r'^Invalid parameter name'):
        node.declare_parameter('', 1)
    with pytest.raises(TypeError, match=r'^First element 5 at index 0 in parameters list is not a str\.$'):
        node.declare_parameter(5, 1)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r'^The given value is not one of the allowed types'):
        node.declare_parameter('dict', {'a': 1})


def test_a_parameter_without_a_value_is_not_initialised(node: Node) -> None:
    node.declare_parameter('x', Parameter.Type.INTEGER)
    with pytest.raises(ParameterUninitializedException, match=r"^The parameter 'x' is not initialized: x$"):
        node.get_parameter('x')
    assert node.get_parameter_or('x', Parameter('x', value=5)).value == 5
    assert node.get_parameter_or('nope').value is None
    assert node.set_parameters([Parameter('x', value=2)])[0].successful
    assert node.get_parameter('x').value == 2


def test_several_at_once(node: Node) -> None:
    declared = node.declare_parameters('ns', [('a', 1), ('b', 2.0), ('c', 'x')])
    assert [parameter.name for parameter in declared] == ['ns.a', 'ns.b', 'ns.c']
    assert [parameter.value for parameter in node.get_parameters(['ns.a', 'ns.b'])] == [1, 2.0]
    assert set(node.get_parameters_by_prefix('ns')) == {'a', 'b', 'c'}
    assert node.get_parameters_by_prefix('zz') == {}
    with pytest.raises(TypeError, match='First element 1'):
        node.declare_parameters('', [(1, 2)])


def test_what_was_not_declared_is_refused(node: Node) -> None:
    text = r'^Invalid access to undeclared parameter\(s\): nope$'
    with pytest.raises(ParameterNotDeclaredException, match=text):
        node.get_parameter('nope')
    with pytest.raises(ParameterNotDeclaredException, match=text):
        node.undeclare_parameter('nope')
    with pytest.raises(ParameterNotDeclaredException):
        node.set_parameters([Parameter('nope', value=1)])


def test_undeclared_parameters_may_be_allowed(started: Started) -> None:
    node = started(allow_undeclared_parameters=True)
    assert node.get_parameter('x').type_ is Parameter.Type.NOT_SET
    assert node.set_parameters([Parameter('x', value=1)])[0].successful
    assert node.get_parameter('x').value == 1


def test_setting_keeps_the_type(node: Node) -> None:
    node.declare_parameter('i', 1)
    good, bad = node.set_parameters([Parameter('i', value=2), Parameter('i', value='x')])
    assert good.successful
    assert (bad.successful, bad.reason) == (
        False, "Wrong parameter type, expected 'Type.INTEGER' got 'Type.STRING'"
    )  # fmt: skip
    assert node.get_parameter('i').value == 2
    with pytest.raises(TypeError, match=r'^parameter must be instance of type'):
        node.set_parameters([1])  # type: ignore[list-item]


def test_an_undeclared_parameter_is_gone(node: Node) -> None:
    node.declare_parameter('x', 1)
    node.undeclare_parameter('x')
    assert not node.has_parameter('x')
    node.declare_parameter('x', 'text')
