"""Message, service and action classes behave as rosidl's do (checks off, as Jazzy's default)."""

from __future__ import annotations

import builtins
import copy
import pickle
import subprocess
import sys
import threading
import traceback
from array import array
from collections.abc import Callable
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from helpers.names import fresh_package
from helpers.patience import PATIENCE
from helpers.vectors import constants, descriptions

from goalwire.cdr import codec
from goalwire.errors import (
    EncodeTypeError,
    EncodeValueError,
    InterfaceSyntaxError,
    UnknownFieldError,
    UnknownInterfaceError,
)
from goalwire.idl import classes, get_interface, register_definitions, registry
from goalwire.idl.classes import action_class, message_class, service_class


def make(text: str, name: str = 'Demo') -> Any:
    """Return the class of a message given as text."""
    package = fresh_package()
    register_definitions(package, {f'msg/{name}': text})
    return message_class(f'{package}/msg/{name}')


@pytest.fixture(scope='module')
def everything() -> Any:
    """A class with a field of every shape."""
    return make(
        'bool flag\nbyte octet\nchar letter\nint32 number\nfloat64 real\nstring text\nwstring wide\n'
        'int32[3] fixed\nbool[2] flags\nbyte[2] octets\nstring[2] texts\n'
        'float32[] reals\nuint8[<=4] few\nbool[] many\nstring[] names\n'
    )


def test_a_new_message_holds_rosidls_defaults(everything: Any) -> None:
    m = everything()
    assert (m.flag, m.octet, m.letter, m.number, m.real, m.text, m.wide) == (False, b'\0', 0, 0, 0.0, '', '')
    assert m.fixed.tolist() == [0, 0, 0]
    assert m.fixed.dtype == np.int32
    assert (m.flags, m.octets, m.texts) == ([False, False], [b'\0', b'\0'], ['', ''])
    assert (m.reals, m.few, m.many, m.names) == (array('f'), array('B'), [], [])


def test_defaults_of_the_definition_are_used_and_never_shared() -> None:
    cls = make(
        'int32 a 5\nstring s "hi"\nfloat32[] f [1, 2]\nint8[2] g [3, 4]\nstring[] t [x, y]\n'
        'bool[2] b [true, false]'
    )
    one, other = cls(), cls()
    assert (one.a, one.s, one.t, one.b) == (5, 'hi', ['x', 'y'], [True, False])
    assert (one.f, one.g.tolist()) == (array('f', [1, 2]), [3, 4])
    for name in 'fgtb':
        assert getattr(one, name) is not getattr(other, name)
    defaults = (cls.A__DEFAULT, cls.S__DEFAULT, cls.F__DEFAULT)
    assert defaults == (5, 'hi', array('f', [1, 2]))


def test_keywords_fill_fields_and_nothing_goes_by_position() -> None:
    cls = make('int32 a\nint32 b', 'String')
    assert (cls(b=2).a, cls(b=2).b) == (0, 2)
    with pytest.raises(TypeError, match=r'String.__init__\(\) takes 1 positional argument but 2 were given'):
        cls('a')


def test_a_keyword_that_names_no_field_is_refused_with_the_near_one() -> None:
    cls = make('int32 data\nint32 other')
    for kind in (UnknownFieldError, AssertionError, TypeError):
        with pytest.raises(
            kind, match='Invalid arguments passed to constructor: dta; Demo has no such field, '
        ):
            cls(dta=1)
    with pytest.raises(UnknownFieldError, match=r'did you mean data\?'):
        cls(other=2, dta=1)
    with pytest.raises(UnknownFieldError, match=r'constructor: _data, zzz; .*did you mean data'):
        cls(zzz=1, _data=2)
    with pytest.raises(UnknownFieldError, match='it has data, other'):
        cls(zzz=1)
    with pytest.raises(UnknownFieldError, match='it has no fields'):
        make('')(zzz=1)


@pytest.mark.parametrize(
    ('text', 'value', 'kind', 'said'),
    [
        ('float64[] p', ['a'], TypeError, "must be real number, not str; p[0] is 'a'"),
        ('float64[] p', [1.0, 2.0, None], TypeError, 'must be real number, not NoneType; p[2] is None'),
        ('float64[] p', 5, TypeError, 'a list is needed, got 5: write p=[5]'),
        ('float64[] p', 'abc', TypeError, "p is 'abc'"),
        ('float64[] p', (item for item in 'ab'), TypeError, 'must be real number, not str; p is <generator'),
        ('uint8[] p', [1, 300], OverflowError, 'unsigned byte integer is greater than maximum; p[1] is 300'),
        ('uint8[<=3] p', [1, -3], OverflowError, 'unsigned byte integer is less than minimum; p[1] is -3'),
        ('float64[2] p', [1.0, 'b'], ValueError, "could not convert string to float: 'b'; p[1] is 'b'"),
        ('int32[2] p', [1, None], TypeError, 'p[1] is None'),
        ('float64[] p', ['x' * 9999], TypeError, "p[0] is 'xxxxxxxxxxxx...xxxxxxxxxxxxx'"),
    ],
)
@pytest.mark.parametrize('way', ['keyword', 'attribute', 'checked'])
def test_a_wrong_value_in_a_sequence_of_numbers_is_named_in_one_error(
    text: str, value: object, kind: type[Exception], said: str, way: str
) -> None:
    cls = make(text)
    kinds: tuple[type[Exception], ...] = (kind,)
    if way == 'checked' and not isinstance(value, list):
        pytest.skip('the setter has words of its own')
    fill = (lambda: setattr(cls(), 'p', value)) if way == 'attribute' else partial(cls, p=value)
    if way == 'checked':
        fill, kinds = partial(cls, p=value, check_fields=True), (kind, AssertionError)
    with pytest.raises(kinds) as caught:
        fill()
    if not isinstance(caught.value, AssertionError):
        assert str(caught.value).startswith("The 'p' field: ")
        assert said in str(caught.value)
    assert 'During handling' not in ''.join(traceback.format_exception(caught.value))


def test_a_wrong_value_deep_inside_is_one_error() -> None:
    package = fresh_package()
    register_definitions(
        package, {'msg/Outer': 'Inner[] all', 'msg/Inner': 'Leaf leaf', 'msg/Leaf': 'string s'}
    )
    outer, inner, leaf = (get_interface(f'{package}/msg/{name}') for name in ('Outer', 'Inner', 'Leaf'))
    for wrong in (5, [5], [inner(leaf=5)], [inner(leaf=inner())], [inner(leaf=leaf(s=b'x'))]):
        with pytest.raises(EncodeTypeError) as caught:
            codec.encode(outer(all=wrong))
        error: BaseException = caught.value
        assert (error.__context__, error.__cause__) == (None, None)
        assert 'During handling' not in ''.join(traceback.format_exception(error))


# The names that a class of ours, or its metaclass, has for itself: without underscores around them.
OWN_NAMES = sorted(
    {
        name.strip('_')
        for cls in (type(make('int32[] a\nint32[2] b\nstring c "x"')), make('int32 a'))
        for name in (*dir(cls), *vars(sys.modules['goalwire.idl.class_making']), *dir(builtins))
        if name.strip('_').isidentifier()
    }
    | {
        'unset',
        'self',
        'value',
        'other',
        'unknown',
        'to_array',
        'kept',
        'dtype',
        'default',
        'new',
        'check',
    }
)


@pytest.mark.parametrize('change', [str.lower, str.upper], ids=['field', 'constant'])
def test_a_name_that_the_class_uses_itself_works_or_is_refused(change: Callable[[str], str]) -> None:
    refused = set()
    for own in OWN_NAMES:
        name = change(own)
        as_field = f'int32[] {name}\nstring[2] {name}s'
        try:
            cls = make(as_field if change is str.lower else f'int32 {name}=7\nint32[] x [1]')
        except InterfaceSyntaxError as error:
            refused.add(name)
            assert 'is taken by' in str(error) or '__' in name  # noqa: PT017
            continue
        message = cls(check_fields=True)
        assert message == cls()
        assert codec.decode(codec.encode(message), cls) == message
        assert len(cls.SLOT_TYPES) == len(cls.get_fields_and_field_types())
        if change is str.upper:
            assert (getattr(cls, name), getattr(message, name)) == (7, 7)
        else:
            assert repr(message).endswith(f"Demo({name}=[], {name}s=['', ''])")
    taken = {'check_fields', 'get_fields_and_field_types', 'fields_and_field_types'}
    assert refused >= (taken if change is str.lower else {'SLOT_TYPES'})


@pytest.mark.parametrize('name', ['None', 'True', 'False'])
@pytest.mark.parametrize(('kind', 'text'), [('msg', ''), ('srv', '---'), ('action', '---\n---')])
def test_a_type_cannot_have_a_name_of_python(name: str, kind: str, text: str) -> None:
    with pytest.raises(
        InterfaceSyntaxError, match=rf"{kind}/{name}\.{kind}:0:0: '{name}' is taken .* rename"
    ):
        register_definitions(fresh_package(), {f'{kind}/{name}': text})


def test_infinities_and_nan_may_be_defaults() -> None:
    cls = make('float64[] x [inf, nan]\nfloat32[2] y [-inf, nan]\nfloat64[<=2] z [Infinity]\nfloat32 w nan')
    message = cls()
    assert repr(message).endswith('Demo(x=[inf, nan], y=array([-inf,  nan], dtype=float32), z=[inf], w=nan)')
    assert message.x is not cls().x
    assert codec.encode(codec.decode(codec.encode(message), cls)) == codec.encode(message)


def test_fields_may_have_the_names_of_builtins_and_of_self() -> None:
    names = ['self', 'range', 'list', 'property', 'isinstance', 'array', 'type', 'value', 'other', 'cls']
    cls = make('\n'.join(f'int32 {name}\nint32[2] {name}s' for name in names))
    assert repr(cls()).count('=0') == len(names)
    assert cls(range=3).range == 3
    assert cls() == cls()


def test_single_values_are_stored_as_given(everything: Any) -> None:
    m = everything(flag='x', number=2.5, text=None)
    assert (m.flag, m.number, m.text) == ('x', 2.5, None)


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        ([0.5], [0.5]),
        ((1, 2), [1.0, 2.0]),
        (range(2), [0.0, 1.0]),
        (array('d', [1.5]), [1.5]),
        (np.array([1.5], dtype=np.float32), [1.5]),
        (np.array([1.5]), [1.5]),
        (np.arange(6, dtype=np.float32)[::2], [0.0, 2.0, 4.0]),
        (memoryview(array('f', [2.5])), [2.5]),
    ],
)
def test_primitive_sequences_become_arrays(everything: Any, value: object, expected: list[float]) -> None:
    m = everything()
    m.reals = value
    assert m.reals == array('f', expected)
    assert m.reals.typecode == 'f'


def test_a_given_array_is_copied(everything: Any) -> None:
    given = array('f', [1.0])
    assert everything(reals=given).reals is not given


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        (b'ab', [97, 98]),
        (bytearray(b'a'), [97]),
        (memoryview(b'ab'), [97, 98]),
        (np.array([1], np.uint8), [1]),
    ],
)
def test_bytes_fill_a_sequence_of_uint8(everything: Any, value: object, expected: list[int]) -> None:
    assert everything(few=value).few == array('B', expected)


@pytest.mark.parametrize(
    ('field', 'value', 'error'),
    [
        ('few', [256], OverflowError),
        ('few', [-1], OverflowError),
        ('few', 'ab', TypeError),
        ('few', None, TypeError),
        ('few', [1.0], TypeError),
        ('reals', ['1'], TypeError),
        ('reals', 5, TypeError),
        ('fixed', None, TypeError),
        ('fixed', ['a'], ValueError),
    ],
)
def test_what_no_array_can_hold_raises_at_once(
    everything: Any, field: str, value: object, error: type[Exception]
) -> None:
    with pytest.raises(error):
        setattr(everything(), field, value)


def test_fixed_arrays_become_numpy_arrays_of_any_length(everything: Any) -> None:
    m = everything(fixed=[1, 2])
    assert m.fixed.tolist() == [1, 2]
    assert m.fixed.dtype == np.int32


def test_a_fixed_array_that_was_decoded_can_be_changed_in_place() -> None:
    cls = make('float64[3] numbers')
    m = codec.decode(codec.encode(cls(numbers=[1, 2, 3])), cls)
    m.numbers[1] = 7.0
    assert m.numbers.tolist() == [1.0, 7.0, 3.0]
    assert repr(m.numbers.dtype) == "dtype('float64')", 'the byte order of the machine, as numpy names it'
    assert codec.decode(codec.encode(m), cls).numbers.tolist() == [1.0, 7.0, 3.0]


def test_messages_do_not_share_the_default_of_a_fixed_array() -> None:
    cls = make('int32[2] numbers [5, 6]')
    one, other = cls(), cls()
    one.numbers[0] = 7
    assert (one.numbers.tolist(), other.numbers.tolist(), cls().numbers.tolist()) == ([7, 6], [5, 6], [5, 6])


def test_an_array_that_was_read_equals_one_that_was_not() -> None:
    cls = make('int16[2] numbers [5, 6]')
    read, unread = cls(), cls()
    assert read.numbers.tolist() == [5, 6]
    assert (read == unread, unread == read, cls(numbers=[5, 7]) == unread) == (True, True, False)
    assert copy.deepcopy(cls()) == read


def test_bytes_are_the_values_of_a_uint8_array() -> None:
    cls = make('uint8[3] octets\nint16[2] numbers')
    assert cls(octets=b'\1\2\3').octets.tolist() == [1, 2, 3]
    assert cls(octets=b'\1\2\3', check_fields=True).octets.tolist() == [1, 2, 3]
    assert codec.decode(codec.encode(cls(octets=b'\1\2\3')), cls) == cls(octets=[1, 2, 3])
    with pytest.raises(EncodeValueError, match='octets: expected exactly 3 values, got 2'):
        codec.encode(cls(octets=b'\1\2'))
    with pytest.raises(ValueError, match='numbers'):
        cls(numbers=b'\1\2\3\4')


def test_repr_shows_package_kind_and_values() -> None:
    from geometry_msgs.msg import Point32, Polygon
    from unique_identifier_msgs.msg import UUID

    assert repr(Polygon(points=[Point32(x=1.0)])) == (
        'geometry_msgs.msg.Polygon(points=[geometry_msgs.msg.Point32(x=1.0, y=0.0, z=0.0)])'
    )
    assert repr(UUID()).startswith('unique_identifier_msgs.msg.UUID(uuid=array([0, 0,')
    fibonacci: Any = action_class('example_interfaces/action/Fibonacci')
    assert (
        repr(fibonacci.Result(sequence=[0, 1]))
        == 'example_interfaces.action.Fibonacci_Result(sequence=[0, 1])'
    )


def test_equality_compares_fields_of_the_same_class(everything: Any) -> None:
    assert everything() == everything()
    assert everything(number=1) != everything()
    assert everything(fixed=[1, 2, 3]) != everything()
    assert everything(fixed=[1, 2]) != everything(fixed=[1, 2, 0])
    assert everything(real=float('nan')) != everything(real=float('nan'))
    assert everything() != 1
    assert make('int32 a')() != make('int32 a')()


def test_messages_are_unhashable_unordered_and_have_no_other_attributes() -> None:
    cls = make('int32 a', 'String')
    with pytest.raises(TypeError, match="unhashable type: 'String'"):
        hash(cls())
    with pytest.raises(TypeError, match="'<' not supported"):
        cls() < cls()  # noqa: B015
    with pytest.raises(AttributeError, match="'String' object has no attribute 'foo'"):
        cls().foo = 1
    with pytest.raises(AttributeError, match="property 'a' of 'String' object has no deleter"):
        del cls().a
    assert type(cls.a) is property


def test_copies_and_pickles_are_equal() -> None:
    from geometry_msgs.msg import PoseStamped

    fibonacci: Any = action_class('example_interfaces/action/Fibonacci')
    pose = PoseStamped()
    pose.header.frame_id = 'map'
    for message in (pose, fibonacci.Goal(order=2), fibonacci.Impl.SendGoalService.Request()):
        assert copy.deepcopy(message) == message
        assert pickle.loads(pickle.dumps(message)) == message
    assert copy.copy(pose).header is pose.header


def test_slots_and_module_are_rosidls() -> None:
    cls = message_class('std_msgs/msg/UInt8MultiArray')
    assert cls.__slots__ == ['_layout', '_data', '_check_fields']  # type: ignore[attr-defined]
    assert (cls.__module__, cls.__name__, cls.__qualname__) == (
        'std_msgs.msg._u_int8_multi_array', 'UInt8MultiArray', 'UInt8MultiArray',
    )  # fmt: skip
    assert type(cls).__name__ == 'Metaclass_UInt8MultiArray'
    assert not hasattr(cls(), '__dict__')


def test_the_dict_of_field_types_is_the_callers_own() -> None:
    cls: Any = message_class('std_msgs/msg/String')
    cls.get_fields_and_field_types().clear()
    assert cls.get_fields_and_field_types() == {'data': 'string'}


def test_constants_match_the_vectors(monkeypatch: pytest.MonkeyPatch) -> None:
    for type_name, expected in constants().items():
        cls = get_interface(type_name)
        for name, value in expected.items():
            found = getattr(cls, name)
            assert (list(found) if isinstance(found, bytes) else found) == value, f'{type_name}.{name}'


def test_constants_are_read_only_in_class_and_message() -> None:
    status: Any = message_class('diagnostic_msgs/msg/DiagnosticStatus')
    assert (status.OK, status.STALE, status().ERROR) == (b'\x00', b'\x03', b'\x02')
    with pytest.raises(AttributeError, match="'DiagnosticStatus' object attribute 'OK' is read-only"):
        status().OK = 1
    with pytest.raises(
        AttributeError, match="property 'OK' of 'Metaclass_DiagnosticStatus' object has no setter"
    ):
        status.OK = 1


def test_the_constants_are_in_rosidls_private_dictionary_too() -> None:
    event: Any = message_class('service_msgs/msg/ServiceEventInfo')
    named = event._Metaclass_ServiceEventInfo__constants  # ros2 service echo names the events by it
    assert named == {'REQUEST_SENT': 0, 'REQUEST_RECEIVED': 1, 'RESPONSE_SENT': 2, 'RESPONSE_RECEIVED': 3}
    empty: Any = message_class('std_srvs/srv/Empty_Request')
    assert empty._Metaclass_Empty_Request__constants == {}


def test_a_field_set_on_the_class_is_every_messages_as_with_rosidl() -> None:
    package = fresh_package()
    register_definitions(package, {'msg/Named': 'string name\nint32 number 3'})
    cls: Any = message_class(f'{package}/msg/Named')
    plain = cls.name
    message = cls(name='own')
    cls.name = 'arm'  # ros2 param delete writes `Parameter.name = …`, of the class
    assert (message.name, repr(message)) == ('arm', f"{package}.msg.Named(name='arm', number=3)")
    assert codec.encode(message)[8:12] == b'arm\0'
    with pytest.raises(AttributeError, match='read-only'):
        message.name = 'leg'
    cls.name = plain
    assert message.name == 'own'
    message.name = 'leg'
    assert (message.name, cls(name='foot').name) == ('leg', 'foot')


def test_a_service_class_holds_its_messages_and_cannot_be_made() -> None:
    service: Any = service_class('example_interfaces/srv/AddTwoInts')
    assert service.Request is message_class('example_interfaces/srv/AddTwoInts_Request')
    assert service.Response.__name__ == 'AddTwoInts_Response'
    assert list(service.Event.get_fields_and_field_types()) == ['info', 'request', 'response']
    assert service.Request.__module__ == 'example_interfaces.srv._add_two_ints'
    with pytest.raises(NotImplementedError, match='Service classes can not be instantiated'):
        service()


def test_an_action_class_holds_all_its_parts_and_cannot_be_made() -> None:
    action: Any = action_class('example_interfaces/action/Fibonacci')
    assert action.Goal.__name__ == 'Fibonacci_Goal'
    assert action.Result is message_class('example_interfaces/action/Fibonacci_Result')
    assert list(action.Feedback.get_fields_and_field_types()) == ['sequence']
    impl = action.Impl
    assert list(impl.SendGoalService.Request.get_fields_and_field_types()) == ['goal_id', 'goal']
    assert list(impl.GetResultService.Response.get_fields_and_field_types()) == ['status', 'result']
    assert list(impl.FeedbackMessage.get_fields_and_field_types()) == ['goal_id', 'feedback']
    assert impl.CancelGoalService is service_class('action_msgs/srv/CancelGoal')
    assert impl.GoalStatusMessage is message_class('action_msgs/msg/GoalStatusArray')
    with pytest.raises(NotImplementedError, match='Action classes can not be instantiated'):
        action()


def test_every_class_has_the_fields_of_the_vectors() -> None:
    for type_name, fields in descriptions().items():
        if type_name.startswith('humanoid_') or fields[0]['name'] in ('request_message', 'goal'):
            continue
        cls: Any = get_interface(type_name)
        names = [field['name'] for field in fields if field['name'] != 'structure_needs_at_least_one_member']
        assert list(cls.get_fields_and_field_types()) == names
        assert len(cls.SLOT_TYPES) == len(names)


def test_a_class_of_the_wrong_kind_is_refused() -> None:
    with pytest.raises(UnknownInterfaceError, match='is not a service'):
        service_class('std_msgs/msg/String')
    with pytest.raises(UnknownInterfaceError, match='is not an action'):
        action_class('std_srvs/srv/SetBool')
    with pytest.raises(UnknownInterfaceError, match='is not a message'):
        message_class('std_srvs/srv/SetBool')


def test_a_class_with_an_unknown_nested_type_is_refused_by_file_and_line() -> None:
    package = fresh_package()
    register_definitions(package, {'msg/Foo': 'int32 x\nBar bar', 'msg/Good': 'int32 x'})
    with pytest.raises(InterfaceSyntaxError, match=f'{package}/msg/Foo.msg:2:1: field bar: '):
        message_class(f'{package}/msg/Foo')
    assert message_class(f'{package}/msg/Good').__name__ == 'Good'


def test_an_unknown_package_inside_is_refused_by_file_line_and_field() -> None:
    package = fresh_package()
    register_definitions(package, {'msg/Foo': 'int32 x\nnowhere_msgs/Bar[] bars'})
    with pytest.raises(
        InterfaceSyntaxError, match=r'Foo.msg:2:1: field bars: nowhere_msgs/msg/Bar: no package'
    ):
        message_class(f'{package}/msg/Foo')


def test_a_message_that_contains_itself_is_refused_with_the_whole_circle() -> None:
    package = fresh_package()
    register_definitions(package, {'msg/A': 'B b', 'msg/B': 'int32 x\nA[] a'})
    circle = f'{package}/msg/A -> {package}/msg/B -> {package}/msg/A'
    with pytest.raises(InterfaceSyntaxError, match=f'cannot contain itself: {circle}'):
        message_class(f'{package}/msg/A')


def test_many_threads_get_the_same_class() -> None:
    package = fresh_package()
    register_definitions(package, {'msg/Foo': 'Bar[] bars', 'msg/Bar': 'int32 x'})
    start = threading.Barrier(8, timeout=PATIENCE)
    found: list[type] = []

    def build() -> None:
        start.wait(PATIENCE)
        found.append(message_class(f'{package}/msg/Foo'))

    threads = [threading.Thread(target=build) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert len(found) == 8
    assert len(set(found)) == 1


def test_tracebacks_show_the_generated_lines(everything: Any) -> None:
    try:
        everything(few=None)
    except TypeError:
        assert "_to_array('B', few, 'few')" in traceback.format_exc()


def test_messages_need_no_numpy_before_a_fixed_array_is_read() -> None:
    program = (
        'import sys\n'
        'from goalwire.idl import get_message, get_service\n'
        "get_message('sensor_msgs/msg/JointState')(name=['a'], position=[1.0])\n"
        "get_service('std_srvs/srv/SetBool').Request()\n"
        'from goalwire.cdr.codec import decode, encode\n'
        "odometry = get_message('nav_msgs/msg/Odometry')\n"
        'decode(encode(odometry()), odometry)\n'
        "print(sorted({'numpy', 'asyncio', 'yaml', 'rich'} & set(sys.modules)))\n"
    )
    result = subprocess.run(
        [sys.executable, '-c', program], capture_output=True, text=True, timeout=30, check=False
    )
    assert (result.stdout, result.stderr) == ('[]\n', '')


def test_sequences_are_set_while_another_thread_is_importing_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = make('int32[] values')
    monkeypatch.setitem(sys.modules, 'numpy', ModuleType('numpy'))  # as it is at its import's beginning
    assert pair(values=[1, 2]).values == array('i', [1, 2])


def test_a_class_keeps_its_definition_and_others_have_none() -> None:
    string = message_class('std_msgs/msg/String')
    assert classes.own_definition(string) is registry.definition('std_msgs/msg/String')
    assert classes.own_definition(type('Derived', (string,), {})) is None
    assert classes.own_definition(int) is None
