"""rosidl_adapter.parser, as ros2 interface, rosapi and rosbridge use it.

Its output was compared, text by text, with that of the rosidl_adapter of Jazzy that PyPI carries.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from rosidl_adapter import parser
from rosidl_adapter.parser import BaseType, Constant, Field, MessageSpecification, Type

from goalwire.idl import registry, search_path
from goalwire.idl.model import ActionDefinition, MessageDefinition, ServiceDefinition, Shape
from goalwire.idl.model import Field as Known

SHIPPED = sorted(Path(search_path.SHIPPED).glob('*/*/*.*'))
TEXT = """\
# A joint.
# Of any robot.

uint8 LIMIT=0x1f # reached
string NAME = "elbow \\"2\\""

# Where it is [rad]
float64 angle 0.5
  # from rest

geometry_msgs/Point[<=3] path
Limit[2] limits   # one below, one above
string<=5[] tags ["a, b", 'c']
"""


@pytest.fixture
def joint() -> MessageSpecification:
    return parser.parse_message_string('arm', 'Joint', TEXT)


def test_a_specification_has_fields_and_constants_with_types_and_values(joint: MessageSpecification) -> None:
    assert (str(joint.base_type), joint.msg_name) == ('arm/Joint', 'Joint')
    assert [(c.type, c.name, c.value) for c in joint.constants] == [
        ('uint8', 'LIMIT', 31), ('string', 'NAME', 'elbow "2"')
    ]  # fmt: skip
    assert [(str(field.type), field.name, field.default_value) for field in joint.fields] == [
        ('float64', 'angle', 0.5),
        ('geometry_msgs/Point[<=3]', 'path', None),
        ('arm/Limit[2]', 'limits', None),
        ('string<=5[]', 'tags', ['a, b', 'c']),
    ]


def test_types_say_what_they_are_made_of(joint: MessageSpecification) -> None:
    angle, path, limits, tags = (field.type for field in joint.fields)
    assert (angle.pkg_name, angle.type, angle.is_primitive_type()) == (None, 'float64', True)
    assert (path.pkg_name, path.type, path.is_primitive_type()) == ('geometry_msgs', 'Point', False)
    assert (path.is_array, path.array_size, path.is_upper_bound, path.is_dynamic_array()) == (
        True, 3, True, True
    )  # fmt: skip
    assert (limits.is_fixed_size_array(), limits.is_dynamic_array()) == (True, False)
    assert (tags.string_upper_bound, BaseType.__str__(tags)) == (5, 'string<=5')
    assert path == Type('Point[<=3]', 'geometry_msgs')
    assert len({path, Type('geometry_msgs/Point[<=3]')}) == 1


def test_comments_and_units_stand_beside_what_they_are_about(joint: MessageSpecification) -> None:
    assert joint.annotations == {'comment': ['A joint.', 'Of any robot.']}
    assert joint.constants[0].annotations == {'comment': ['reached']}
    assert joint.fields[0].annotations == {'comment': ['Where it is', 'from rest'], 'unit': 'rad'}
    assert joint.fields[1].annotations == {'comment': []}


def test_the_text_of_a_specification_is_a_definition_again(joint: MessageSpecification) -> None:
    assert str(joint).splitlines()[:3] == ['# arm/Joint', 'uint8 LIMIT=31', 'string NAME=\'elbow "2"\'']
    plain = parser.parse_message_string('arm', 'Joint', 'int32 a 5\nstring s "x"\nLimit l')
    assert parser.parse_message_string('arm', 'Joint', str(plain)) == plain


def test_services_and_actions_have_parts() -> None:
    service = parser.parse_service_string('arm', 'Move', 'Joint to\n---\nbool done')
    assert (service.pkg_name, service.srv_name) == ('arm', 'Move')
    assert (service.request.msg_name, service.response.msg_name) == ('Move_Request', 'Move_Response')
    assert str(service).splitlines()[0] == '# arm/Move'
    action = parser.parse_action_string('arm', 'Wave', 'int32 n\n---\n---\nint32 so_far')
    names = [part.msg_name for part in (action.goal, action.result, action.feedback)]
    assert names == ['Wave_Goal', 'Wave_Result', 'Wave_Feedback']
    with pytest.raises(parser.InvalidServiceSpecification, match="separator '---'"):
        parser.parse_service_string('arm', 'Move', 'bool done')
    with pytest.raises(parser.InvalidActionSpecification, match="'---' separators"):
        parser.parse_action_string('arm', 'Wave', '---')


@pytest.mark.parametrize('line', ['Joint to', '# only a comment', '', '   ', 'int32 X=5', 'int32[] a [1, 2]'])
def test_single_lines_are_specifications_as_ros2_interface_show_asks(line: str) -> None:
    found = parser.parse_message_string(pkg_name='arm', msg_name='Joint', message_string=line)
    assert len(found.fields) + len(found.constants) <= 1
    assert 'comment' in found.annotations


@pytest.mark.parametrize(
    ('text', 'error', 'why'),
    [
        ('int32', parser.InvalidFieldDefinition, 'int32'),
        ('foo a', parser.InvalidResourceName, "'foo' is an invalid message name"),
        ('Arm/Foo a', parser.InvalidResourceName, "'Arm' is an invalid package name"),
        ('a/msg/Foo a', parser.InvalidResourceName, 'a/msg/Foo'),
        ('int32 a__b', NameError, "'a__b' is an invalid field name"),
        ('int32 Ab=1', NameError, "'Ab' is an invalid constant name"),
        ('Foo A=1', TypeError, "constant type 'Foo' must be a primitive"),
        ('int32 a\nint32 a', ValueError, 'duplicate names: a'),
        ('int8 a 128', parser.InvalidValue, 'must be a valid integer value >= -128 and <= 127'),
        ('bool a yes', parser.InvalidValue, "must be either 'true'"),
        ('float32 a 1,5', parser.InvalidValue, "using '.' as the separator"),
        ('int32[2] a [1]', parser.InvalidValue, 'must have exactly 2 elements, not 1'),
        ('int32[<=1] a [1, 2]', parser.InvalidValue, 'not more than 1 elements, not 2'),
        ('int32[] a 1', parser.InvalidValue, r"must start with '\['"),
        ('int32[] a [x]', parser.InvalidValue, "element 0 with value 'x'"),
        ('string<=2 a "abc"', parser.InvalidValue, 'maximum length of 2'),
        ('string a "b"c"', parser.InvalidValue, 'quotes not properly escaped'),
        ('string[] a ["b', parser.InvalidValue, r"end with '\]'"),
        ('string[] a ["b]', ValueError, 'incorrectly quoted'),
        ('Foo a 1', NotImplementedError, "type 'arm/Foo' is not supported"),
        ('int32[0] a', TypeError, 'must be a valid integer value > 0'),
        ('string<=x a', TypeError, 'upper bound of the string type'),
        ('int32] a', TypeError, r"does not contain a '\['"),
    ],
)
def test_what_breaks_the_rules_is_refused(
    text: str, error: type[Exception], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(error, match=why):
        parser.parse_message_string('arm', 'Joint', text)
    capsys.readouterr()


def test_a_name_with_many_underscores_is_judged_at_once() -> None:
    assert not parser.is_valid_constant_name('A' * 5000 + '_')
    assert parser.is_valid_constant_name('A_1' * 1000)


def test_names_of_all_kinds() -> None:
    assert parser.is_valid_package_name('my_robot2')
    assert not parser.is_valid_package_name('my__robot')
    assert not parser.is_valid_field_name('Angle')
    assert parser.is_valid_message_name('Move_Request')
    assert parser.is_valid_message_name('Sample_Joint')
    assert not parser.is_valid_message_name('Move_Event')
    for check in (parser.is_valid_field_name, parser.is_valid_message_name, parser.is_valid_constant_name):
        with pytest.raises(parser.InvalidResourceName):
            check(None)  # type: ignore[arg-type]


def test_fields_of_unknown_types_are_found() -> None:
    service = parser.parse_service_string('arm', 'Move', 'Joint to\nint32 n\n---\nbase/Pose[] at')
    parser.validate_field_types(service, [BaseType('arm/Joint'), BaseType('base/Pose')])
    with pytest.raises(parser.UnknownMessageType, match=r'unknown field type: base/Pose\[\] at'):
        parser.validate_field_types(service, [BaseType('arm/Joint')])


def test_only_fields_and_constants_make_a_message() -> None:
    with pytest.raises(TypeError, match="field 0 must be a 'Field' instance"):
        MessageSpecification('arm', 'Joint', ['int32 a'], [])  # type: ignore[list-item]
    with pytest.raises(TypeError, match="must be a 'Type' instance"):
        Field('int32', 'a')  # type: ignore[arg-type]
    assert Constant('int32', 'A', '5') == Constant('int32', 'A', '5') != Constant('int32', 'A', '6')


def shape_of(type_: Type) -> tuple[str, Shape, int, int]:
    """A type in the words of goalwire's model."""
    base = type_.type if type_.pkg_name is None else f'{type_.pkg_name}/msg/{type_.type}'
    shape = Shape.SINGLE
    if type_.is_array:
        shape = Shape.ARRAY if type_.is_fixed_size_array() else Shape.BOUNDED
        shape = shape if type_.array_size else Shape.UNBOUNDED
    return base, shape, type_.array_size or 0, type_.string_upper_bound or 0


def shape_known(field: Known) -> tuple[str, Shape, int, int]:
    return field.type.base, field.type.shape, field.type.capacity, field.type.string_capacity


@pytest.mark.parametrize('package', sorted({file.parent.parent.name for file in SHIPPED}))
def test_every_shipped_definition_is_read_as_the_classes_are(package: str) -> None:
    for file in (file for file in SHIPPED if file.parent.parent.name == package and file.suffix != '.xml'):
        known = registry.definition(f'{package}/{file.parent.name}/{file.stem}')
        if isinstance(known, MessageDefinition):
            pairs = [(parser.parse_message_file(package, str(file)), known)]
        elif isinstance(known, ServiceDefinition):
            service = parser.parse_service_file(package, str(file))
            pairs = [(service.request, known.request), (service.response, known.response)]
        else:
            assert isinstance(known, ActionDefinition)
            action = parser.parse_action_file(package, str(file))
            pairs = [
                (action.goal, known.goal), (action.result, known.result), (action.feedback, known.feedback)
            ]  # fmt: skip
        for found, wanted in pairs:
            assert [(field.name, shape_of(field.type)) for field in found.fields] == [
                (field.name, shape_known(field)) for field in wanted.fields
            ], file
            assert [constant.name for constant in found.constants] == [c.name for c in wanted.constants], file
