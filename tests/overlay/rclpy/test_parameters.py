"""Parameters of a node: declared, overridden, read, set, watched by callbacks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterValue,
    SetParametersResult,
)
from rclpy.context import Context
from rclpy.exceptions import (
    InvalidHandle,
    InvalidParameterException,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from goalwire.errors import CallbackError, RCLError, RCLInvalidROSArgsError

# Nothing here is the wire's business.
pytestmark = pytest.mark.parametrize('transport_name', ['goalwire_memory'])

Started: TypeAlias = Callable[..., Node]
Type = Parameter.Type


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


def value_of(node: Node, name: str) -> object:
    return node.get_parameter(name).value


# -- declaring -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    'value', [True, 1, 1.5, 'text', [b'a'], [True, False], [1, 2], [1.0], ['x', 'y']], ids=repr
)
def test_a_parameter_is_declared_with_its_default(node: Node, value: Any) -> None:
    declared = node.declare_parameter('x', value)
    assert (declared.name, declared.value) == ('x', value)
    assert declared.type_ is Type.from_parameter_value(value)
    assert value_of(node, 'x') == value
    assert node.has_parameter('x')
    assert node.get_parameter_type('x') == declared.type_.value


@pytest.mark.parametrize('name', ['x.y.z', 'x..y', '.lead', 'sp ace', 'ü'])
def test_a_name_may_be_anything_but_empty(node: Node, name: str) -> None:
    assert node.declare_parameter(name, 1).name == name
    with pytest.raises(InvalidParameterException, match=r'^Invalid parameter name: $'):
        node.declare_parameter('', 1)


@pytest.mark.parametrize(
    ('given', 'text'),
    [
        ((5, 1), 'First element 5 at index 0 in parameters list is not a str.'),
        (('x', {'a': 1}), "The given value is not one of the allowed types '{'a': 1}'."),
        (('x', 1, 2), 'Third element 2 at index 0 in parameters list is not a ParameterDescriptor.'),
        ((), 'Invalid parameter tuple length at index 0 in parameters list: (); expecting length between'),
        (('x', 1, None, 4), 'Invalid parameter tuple length at index 0 in parameters list: ('),
    ],
)
def test_a_declaration_of_the_wrong_kind_is_refused(node: Node, given: Any, text: str) -> None:
    with pytest.raises(TypeError) as raised:
        node.declare_parameters('', [given, ('after', 1)])
    assert str(raised.value).startswith(text)
    assert not node.has_parameter('after')


@pytest.mark.parametrize(
    ('value', 'descriptor', 'text'),
    [
        (None, ParameterDescriptor(), "of type PARAMETER_NOT_SET: 'x' has neither a value nor a type"),
        (Type.NOT_SET, None, 'Cannot declare parameter {x} as statically typed of type NOT_SET'),
        (
            Type.INTEGER,
            ParameterDescriptor(dynamic_typing=True),
            'with `dynamic_typing=True` is not allowed when the parameter type is provided',
        ),
    ],
)
def test_a_declaration_must_tell_one_type(node: Node, value: Any, descriptor: Any, text: str) -> None:
    with pytest.raises(ValueError) as raised:
        node.declare_parameter('x', value, descriptor)
    assert str(raised.value).endswith(text)


@pytest.mark.parametrize(
    'declare',
    [lambda node: node.declare_parameter('x'), lambda node: node.declare_parameters('', [('x',)])],
)
def test_a_name_alone_is_deprecated_and_the_warning_points_at_the_caller(
    node: Node, declare: Callable[[Node], object]
) -> None:
    with pytest.warns(UserWarning, match=r"^when declaring parameter named 'x', declaring") as warned:
        declare(node)
    assert [warning.filename for warning in warned] == [__file__]
    assert value_of(node, 'x') is None
    assert node.describe_parameter('x').dynamic_typing


@pytest.mark.parametrize(
    ('message', 'value'),
    [
        (ParameterValue(type=Type.STRING.value, string_value='x'), 'x'),
        (ParameterValue(type=Type.INTEGER_ARRAY.value, integer_array_value=[1, 2]), [1, 2]),
        (ParameterValue(type=Type.BYTE_ARRAY.value, byte_array_value=[b'a']), [b'a']),
    ],
)
def test_a_default_may_be_a_message(node: Node, message: ParameterValue, value: Any) -> None:
    assert node.declare_parameter('p', message).value == value
    assert node.get_parameter('p').get_parameter_value() == message
    with pytest.raises(ValueError, match='neither a value nor a type'):
        node.declare_parameter('q', ParameterValue())
    assert (
        node.declare_parameter('r', ParameterValue(), ParameterDescriptor(dynamic_typing=True)).value is None
    )


def test_a_parameter_is_declared_once(node: Node) -> None:
    node.declare_parameter('x', 1)
    with pytest.raises(ParameterAlreadyDeclaredException, match=r"^Parameter\(s\) already declared: \['x'\]"):
        node.declare_parameters('', [('y', 1), ('x', 2)])
    assert not node.has_parameter('y')
    node.undeclare_parameter('x')
    assert not node.has_parameter('x')
    node.declare_parameter('x', 'text')


def test_a_parameter_without_a_value_is_not_initialised(node: Node) -> None:
    node.declare_parameter('x', Type.INTEGER)
    with pytest.raises(ParameterUninitializedException, match=r"^The parameter 'x' is not initialized: x$"):
        node.get_parameter('x')
    assert node.get_parameter_or('x', Parameter('x', value=5)).value == 5
    assert node.get_parameter_or('nope').value is None
    assert node.get_parameter_type('x') == 0
    assert node.get_parameters_by_prefix('')['x'].value is None
    assert node.set_parameters([Parameter('x', value=2)])[0].successful
    assert value_of(node, 'x') == 2


def test_several_at_once(node: Node) -> None:
    declared = node.declare_parameters('ns', [('a', 1), ('b', 2.0), ('c', 'x')])
    assert [parameter.name for parameter in declared] == ['ns.a', 'ns.b', 'ns.c']
    assert [parameter.value for parameter in node.get_parameters(['ns.a', 'ns.b'])] == [1, 2.0]
    assert set(node.get_parameters_by_prefix('ns')) == {'a', 'b', 'c'}
    assert node.get_parameters_by_prefix('zz') == {}
    assert list(node.list_parameters(['ns'], 0).names) == ['ns.a', 'ns.b', 'ns.c']
    assert list(node.list_parameters(['ns'], 0).prefixes) == ['ns']


def test_a_descriptor_of_the_caller_s_is_not_written_to(node: Node) -> None:
    shared = ParameterDescriptor(description='shared')
    node.declare_parameter('i', 1, shared)
    node.declare_parameter('s', 'text', shared)
    assert shared == ParameterDescriptor(description='shared')
    assert node.set_parameters([Parameter('i', value=2)])[0].successful
    assert [(found.name, found.type) for found in node.describe_parameters(['i', 's'])] == [
        ('i', 2), ('s', 4)
    ]  # fmt: skip


def test_a_value_out_of_its_range_is_not_declared(node: Node) -> None:
    limits = ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=10, step=5)])
    with pytest.raises(InvalidParameterValueException) as raised:
        node.declare_parameter('r', 50, limits)
    assert str(raised.value) == (
        'Invalid parameter value (50) for parameter. '
        'Reason: Parameter r out of range. Min: 0, Max: 10, value: 50: r'
    )
    assert not node.has_parameter('r')
    node.declare_parameter('r', 5, limits)
    assert node.describe_parameter('r').integer_range == limits.integer_range


def test_what_was_not_declared_is_refused(node: Node) -> None:
    for ask in (
        node.get_parameter,
        node.undeclare_parameter,
        node.get_parameter_type,
        node.describe_parameter,
        lambda name: node.set_descriptor(name, ParameterDescriptor()),
    ):
        with pytest.raises(ParameterNotDeclaredException) as raised:
            ask('nope')
        assert str(raised.value) == 'Invalid access to undeclared parameter(s): nope'


# -- setting -------------------------------------------------------------------------------------------------


def test_setting_keeps_the_type(node: Node) -> None:
    node.declare_parameter('i', 1)
    good, bad, gone = node.set_parameters(
        [Parameter('i', value=2), Parameter('i', value='x'), Parameter('i')]
    )
    assert good == SetParametersResult(successful=True)
    assert bad == SetParametersResult(
        successful=False, reason="Wrong parameter type, expected 'Type.INTEGER' got 'Type.STRING'"
    )
    assert gone == SetParametersResult(successful=False, reason='Static parameter cannot be undeclared')
    assert value_of(node, 'i') == 2
    assert node.set_parameters([]) == []


@pytest.mark.parametrize('what', ['x', [1], [Parameter('i', value=1).to_parameter_msg()]])
def test_only_parameters_are_set(node: Node, what: Any) -> None:
    for set_ in (node.set_parameters, node.set_parameters_atomically):
        with pytest.raises(TypeError, match=r'^parameter must be instance of type'):
            set_(what)


def test_a_name_that_is_not_declared_ends_the_set_but_not_what_came_before(node: Node) -> None:
    node.declare_parameters('', [('i', 1), ('d', 1.5)])
    values = [Parameter('i', value=3), Parameter('nope', value=2), Parameter('d', value=3.0)]
    with pytest.raises(ParameterNotDeclaredException, match=r"undeclared parameter\(s\): \['nope'\]"):
        node.set_parameters(values)
    assert (value_of(node, 'i'), value_of(node, 'd')) == (3, 1.5)


def test_an_atomic_set_is_all_or_nothing(node: Node) -> None:
    node.declare_parameters('', [('i', 1), ('d', 1.5)])
    assert node.set_parameters_atomically([Parameter('i', value=5), Parameter('d', value=5.5)]).successful
    refused = node.set_parameters_atomically([Parameter('i', value=6), Parameter('d', value='bad')])
    assert refused.reason == "Wrong parameter type, expected 'Type.DOUBLE' got 'Type.STRING'"
    with pytest.raises(ParameterNotDeclaredException, match=r"\['nope', 'neither'\]"):
        node.set_parameters_atomically(
            [Parameter('i', value=7), Parameter('nope', value=1), Parameter('neither', value=1)]
        )
    assert (value_of(node, 'i'), value_of(node, 'd')) == (5, 5.5)
    assert node.set_parameters_atomically([]).successful


def test_a_read_only_parameter_stays(started: Started) -> None:
    node = started('-p', 'ro:=5')
    assert node.declare_parameter('ro', 1, ParameterDescriptor(read_only=True)).value == 5
    reason = 'Trying to set a read-only parameter: ro.'
    assert node.set_parameters([Parameter('ro', value=2)])[0].reason == reason
    assert node.set_parameters_atomically([Parameter('ro')]).reason == reason
    for change in (node.undeclare_parameter, lambda name: node.set_descriptor(name, ParameterDescriptor())):
        with pytest.raises(
            ParameterImmutableException, match=r'^Attempted to modify read-only parameter: ro$'
        ):
            change('ro')
    assert value_of(node, 'ro') == 5


def test_a_double_is_kept_in_its_range(node: Node) -> None:
    limits = ParameterDescriptor(
        floating_point_range=[FloatingPointRange(from_value=0.0, to_value=1.0, step=0.1)]
    )
    node.declare_parameter('f', 0.5, limits)
    results = node.set_parameters([Parameter('f', value=value) for value in (0.3, 0.35, 1.1)])
    assert [result.successful for result in results] == [True, False, False]
    assert results[2].reason == 'Parameter f out of range Min: 0.0, Max: 1.0, value: 1.1'
    assert value_of(node, 'f') == 0.3


def test_a_dynamically_typed_parameter_changes_its_type_and_goes_without_a_value(node: Node) -> None:
    node.declare_parameter('dyn', 1, ParameterDescriptor(dynamic_typing=True))
    assert node.set_parameters([Parameter('dyn', value='s')])[0].successful
    assert node.describe_parameter('dyn').type == Type.STRING.value
    assert node.set_parameters([Parameter('dyn')])[0].successful
    assert not node.has_parameter('dyn')


def test_undeclared_parameters_may_be_allowed(started: Started) -> None:
    node = started(allow_undeclared_parameters=True)
    assert node.get_parameter('x').type_ is Type.NOT_SET
    assert node.get_parameter_type('x') is Type.NOT_SET
    assert node.describe_parameter('x') == ParameterDescriptor()
    assert node.set_descriptor('x', ParameterDescriptor()) == ParameterValue()
    for value in (1, 'text'):
        assert node.set_parameters([Parameter('x', value=value)])[0].successful
        assert value_of(node, 'x') == value
    assert node.set_parameters([Parameter('x')])[0].successful
    assert not node.has_parameter('x')
    with pytest.raises(ParameterNotDeclaredException):
        node.undeclare_parameter('x')


def test_a_descriptor_is_replaced_where_it_suits_the_value(node: Node) -> None:
    node.declare_parameter('i', 8)
    for type_, name in ((0, 'NOT_SET'), (4, 'STRING')):
        with pytest.raises(InvalidParameterValueException) as raised:
            node.set_descriptor('i', ParameterDescriptor(type=type_))
        assert str(raised.value) == (
            'Invalid parameter value (8) for parameter. '
            f"Reason: Wrong parameter type, expected 'Type.{name}' got 'Type.INTEGER': i"
        )
    new = ParameterDescriptor(name='other', type=2, description='new')
    assert node.set_descriptor('i', new) == ParameterValue(type=2, integer_value=8)
    assert (node.describe_parameter('i').name, node.describe_parameter('i').description) == ('i', 'new')


def test_a_descriptor_may_bring_the_value_that_suits_it(node: Node) -> None:
    node.declare_parameter('i', 8)
    text = ParameterValue(type=4, string_value='text')
    assert node.set_descriptor('i', ParameterDescriptor(type=4), text) == text
    assert value_of(node, 'i') == 'text'
    with pytest.raises(InvalidParameterValueException, match=r'^Invalid parameter value \(text\)'):
        node.set_descriptor('i', ParameterDescriptor(type=2), text)


def test_a_destroyed_node_sets_nothing(node: Node) -> None:
    node.declare_parameter('x', 1)
    node.destroy_node()
    with pytest.raises(InvalidHandle):
        node.set_parameters([Parameter('x', value=2)])
    assert value_of(node, 'x') == 1


# -- callbacks -----------------------------------------------------------------------------------------------


def test_callbacks_run_before_on_and_after_a_set_the_last_added_first(node: Node) -> None:
    log: list[tuple[str, list[str], object]] = []
    node.declare_parameters('', [('i', 0), ('d', 0.0)])

    def note(when: str, parameters: list[Parameter]) -> None:
        log.append((when, [parameter.name for parameter in parameters], value_of(node, 'i')))

    def before(parameters: list[Parameter]) -> list[Parameter]:
        note('before', parameters)
        return [*parameters, Parameter('d', value=9.0)]

    def on(name: str) -> Callable[[list[Parameter]], SetParametersResult]:
        def callback(parameters: list[Parameter]) -> SetParametersResult:
            note(name, parameters)
            return SetParametersResult(successful=parameters[0].value != 666, reason='devil')

        return callback

    node.add_pre_set_parameters_callback(before)
    node.add_on_set_parameters_callback(on('on'))
    node.add_on_set_parameters_callback(on('on2'))
    node.add_post_set_parameters_callback(lambda parameters: note('after', parameters))
    assert node.set_parameters([Parameter('i', value=1)]) == [SetParametersResult(successful=True)]
    both = ['i', 'd']
    assert log == [('before', ['i'], 0), ('on2', both, 0), ('on', both, 0), ('after', both, 1)]
    log.clear()
    refused = node.set_parameters([Parameter('i', value=666)])
    assert refused == [SetParametersResult(successful=False, reason='devil')]
    assert [when for when, *_ in log] == ['before', 'on2']
    assert (value_of(node, 'i'), value_of(node, 'd')) == (1, 9.0)


def test_callbacks_are_asked_for_a_declaration_too(node: Node) -> None:
    log: list[str] = []
    node.add_on_set_parameters_callback(
        lambda parameters: SetParametersResult(successful=parameters[0].value != 666, reason='devil')
    )
    node.add_pre_set_parameters_callback(lambda _: pytest.fail('that is for sets'))
    node.add_post_set_parameters_callback(lambda parameters: log.append(parameters[0].name))
    node.declare_parameter('good', 1)
    with pytest.raises(InvalidParameterValueException) as raised:
        node.declare_parameters('', [('a', 1), ('evil', 666), ('c', 3)])
    assert str(raised.value) == 'Invalid parameter value (666) for parameter. Reason: devil: evil'
    assert log == ['good', 'a']
    assert [node.has_parameter(name) for name in ('a', 'evil', 'c')] == [True, False, False]


def test_a_read_only_parameter_reaches_no_callback_on_a_set(node: Node) -> None:
    node.declare_parameter('ro', 1, ParameterDescriptor(read_only=True))
    node.add_on_set_parameters_callback(lambda _: pytest.fail('asked'))
    assert not node.set_parameters([Parameter('ro', value=2)])[0].successful


def test_callbacks_before_a_set_must_leave_something(node: Node) -> None:
    node.declare_parameter('i', 1)
    node.add_pre_set_parameters_callback(lambda _: [])
    for result in (
        *node.set_parameters([Parameter('i', value=7)]),
        node.set_parameters_atomically([Parameter('i', value=7)]),
    ):
        assert result.reason == (
            'parameter list cannot be empty, this might be due to pre_set_parameters_callback modifying the '
            'original parameters list.'
        )
    assert value_of(node, 'i') == 1


def test_a_callback_that_fails_refuses_the_set(node: Node) -> None:
    node.declare_parameter('i', 1)
    node.add_on_set_parameters_callback(lambda _: 1 / 0)  # type: ignore[arg-type,return-value]
    with pytest.raises(ZeroDivisionError):
        node.set_parameters([Parameter('i', value=2)])
    node.add_on_set_parameters_callback(lambda _: None)  # type: ignore[arg-type,return-value]
    with pytest.warns(UserWarning, match='so nothing is set; write .return SetParametersResult'):
        (result,) = node.set_parameters([Parameter('i', value=2)])
    assert result.reason.startswith('Callback returned an invalid type: ')
    node.add_pre_set_parameters_callback(lambda _: None)  # type: ignore[arg-type,return-value]
    with pytest.raises(CallbackError, match=r'returned None: return the list of parameters to set$'):
        node.set_parameters([Parameter('i', value=2)])
    assert value_of(node, 'i') == 1


def test_a_callback_may_set_other_parameters(node: Node) -> None:
    node.declare_parameters('', [('i', 1), ('other', 1)])

    def follow(parameters: list[Parameter]) -> None:
        if parameters[0].name == 'i':
            node.set_parameters([Parameter('other', value=parameters[0].value)])

    node.add_post_set_parameters_callback(follow)
    node.set_parameters([Parameter('i', value=5)])
    assert value_of(node, 'other') == 5


@pytest.mark.parametrize('when', ['pre', 'on', 'post'])
def test_callbacks_are_removed_once(node: Node, when: str) -> None:
    add: Callable[[object], None] = getattr(node, f'add_{when}_set_parameters_callback')
    remove: Callable[[object], None] = getattr(node, f'remove_{when}_set_parameters_callback')
    add(len)
    remove(len)
    with pytest.raises(ValueError, match=r'^list\.remove\(x\): x not in list$'):
        remove(len)
    with pytest.raises(TypeError, match=r"^Callback must be callable, got <class 'int'>$"):
        add(5)


# -- overrides -----------------------------------------------------------------------------------------------


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
    node = started('-p', 'x:=1', parameter_overrides=[Parameter('x', value=3), Parameter('ns.y', value=4)])
    assert node.declare_parameter('x', 0).value == 3
    assert node.declare_parameters('ns', [('y', 0)])[0].value == 4
    assert node.declare_parameter('z', 7, ignore_override=True).value == 7


def test_overrides_are_declared_on_demand(started: Started) -> None:
    node = started('-p', 'a.b:=1', automatically_declare_parameters_from_overrides=True)
    assert value_of(node, 'a.b') == 1
    assert not started('-p', 'a.b:=1').has_parameter('a.b')
    with pytest.raises(ValueError, match=r"type PARAMETER_NOT_SET: 'a' has neither a value nor a type$"):
        started('-p', 'a:=[]', automatically_declare_parameters_from_overrides=True)


@pytest.mark.parametrize(
    ('override', 'given', 'text'),
    [
        ('str', 1, "Trying to set parameter 'x' to 'str' of type 'STRING', expecting type 'INTEGER': x"),
        ('1', 1.0, "Trying to set parameter 'x' to '1' of type 'INTEGER', expecting type 'DOUBLE': x"),
        ('[1]', Type.STRING,
         "Trying to set parameter 'x' to '[1]' of type 'INTEGER_ARRAY', expecting type 'STRING': x"),
    ],
)  # fmt: skip
def test_an_override_of_another_type_is_refused(
    started: Started, override: str, given: Any, text: str
) -> None:
    node = started('-p', f'x:={override}')
    with pytest.raises(InvalidParameterTypeException) as raised:
        node.declare_parameter('x', given)
    assert str(raised.value) == text
    [note] = raised.value.__notes__
    assert note.startswith('x: give ')
    assert not node.has_parameter('x')
    dynamic = ParameterDescriptor(dynamic_typing=True)
    assert node.declare_parameter('x', None, dynamic).value is not None


def test_an_override_out_of_range_is_refused(started: Started) -> None:
    limits = ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=10)])
    with pytest.raises(InvalidParameterValueException, match=r'Parameter r out of range\. Min: 0, Max: 10'):
        started('-p', 'r:=50').declare_parameter('r', 1, limits)


# -- files ---------------------------------------------------------------------------------------------------


def overrides(node: Node, name: str = 'x') -> object:
    return node.declare_parameter(name, None, ParameterDescriptor(dynamic_typing=True)).value


@pytest.fixture
def file(tmp_path: Path) -> Callable[[str], str]:
    """Write a parameter file and return its path."""
    written: list[Path] = []

    def write(text: str) -> str:
        written.append(tmp_path / f'{len(written)}.yaml')
        written[-1].write_text(text)
        return str(written[-1])

    return write


def test_a_file_gives_values_to_its_nodes(started: Started, file: Callable[[str], str]) -> None:
    node = started(
        '--params-file',
        file(
            '/**:\n  ros__parameters:\n    x: 1\n    deep: {er: two}\n'
            '/*/nn:\n  ros__parameters: {y: [1.5, 2.5]}\n'
            'ns:\n  nn:\n    ros__parameters: {z: 3}\n'
            '/other:\n  ros__parameters: {x: 9}\n'
        ),
    )
    assert [overrides(node, name) for name in ('x', 'deep.er', 'y', 'z')] == [1, 'two', [1.5, 2.5], 3]


def test_names_of_nodes_take_turns_in_the_order_of_their_first_appearance(
    started: Started, file: Callable[[str], str]
) -> None:
    exact, all_ = '/ns/nn:\n  ros__parameters: {x: 1}\n', '/**:\n  ros__parameters: {x: 2}\n'
    assert overrides(started('--params-file', file(all_ + exact))) == 1
    assert overrides(started('--params-file', file(exact + all_))) == 2
    assert overrides(started('--params-file', file(exact), '-p', 'x:=5')) == 5
    assert overrides(started('-p', 'x:=5', '--params-file', file(exact))) == 1
    assert overrides(started('-p', 'x:=5', '--params-file', file(exact), '-p', 'x:=6')) == 1
    own = ['--ros-args', '-p', 'x:=7']
    assert overrides(started('-p', 'x:=5', '--params-file', file(exact), cli_args=own)) == 7


def test_a_mistake_in_a_file_is_told_at_init_with_file_and_line(
    isolated: dict[str, str], file: Callable[[str], str]
) -> None:
    path = file('/**:\n  ros__parameters:\n    a: [1, 2.0]\n')
    with pytest.raises(RCLError) as raised:
        Context().init(args=['--ros-args', '--params-file', path])
    assert str(raised.value) == (
        f"failed to initialize rcl: Couldn't parse params file: '--params-file {path}'. Error: "
        "Sequence should be of same type. Value type 'double' do not belong at line_num 3"
    )


def test_a_mistake_in_a_node_s_own_file_is_told_with_the_node(
    started: Started, file: Callable[[str], str]
) -> None:
    path = file('- a\n')
    with pytest.raises(RCLInvalidROSArgsError) as raised:
        started(cli_args=['--ros-args', '--params-file', path])
    assert str(raised.value) == (
        "Failed to parse ROS arguments: Couldn't parse params file: "
        f"'--params-file {path}'. Error: Sequences cannot be key at line 1"
    )


def test_a_file_that_is_not_there_is_named(started: Started, tmp_path: Path) -> None:
    missing = tmp_path / 'missing.yaml'
    with pytest.raises(
        RCLError, match=rf"'--params-file {missing}'\. Error: Error opening YAML file: No such"
    ):
        started('--params-file', str(missing))
