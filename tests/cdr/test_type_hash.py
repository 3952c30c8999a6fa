"""Type hashes and what else is told from a definition; the hashes themselves are in test_vectors.py."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.names import fresh_package
from helpers.vectors import WORKSPACE, descriptions

from goalwire.cdr.type_hash import described_fields, type_id
from goalwire.errors import InterfaceSyntaxError, UnknownInterfaceError
from goalwire.idl import definition, get_message, has_buffer_fields, register_definitions, type_hash


def test_a_class_and_its_name_have_the_same_hash() -> None:
    from std_msgs.msg import String
    from std_srvs.srv import SetBool

    assert type_hash(String) == type_hash('std_msgs/msg/String')
    assert type_hash(String) == 'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18'
    assert type_hash(SetBool) == type_hash('std_srvs/srv/SetBool')


def test_descriptions_match_ros2(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_INTERFACE_PATH', str(WORKSPACE))
    for type_name, expected in descriptions().items():
        found = [
            {
                'name': field.name,
                'type_id': type_id(field.type),
                'capacity': field.type.capacity,
                'string_capacity': field.type.string_capacity,
                'nested_type_name': field.type.base if field.type.is_message else '',
            }
            for field in described_fields(definition(type_name))
        ]
        defaults = {'capacity': 0, 'string_capacity': 0, 'nested_type_name': ''}
        wanted = [{**defaults, **{key: item[key] for key in item if key != 'default'}} for item in expected]
        assert found == wanted, type_name


def test_defaults_constants_and_comments_do_not_change_the_hash() -> None:
    package = fresh_package()
    register_definitions(package, {'msg/Foo': 'int32 x'})
    plain = type_hash(f'{package}/msg/Foo')
    other = fresh_package()
    register_definitions(other, {'msg/Foo': '# hi\nint32 A=1\nint32 x 5 # five'})
    register_definitions(fresh_package(), {'msg/Foo': 'int64 x'})
    assert plain != type_hash(f'{other}/msg/Foo')  # the package's name is part of it
    assert [field.type for field in described_fields(definition(f'{package}/msg/Foo'))] == [
        field.type for field in described_fields(definition(f'{other}/msg/Foo'))
    ]


def test_what_is_no_interface_has_no_hash() -> None:
    with pytest.raises(
        UnknownInterfaceError, match="<class 'int'> is not a message, service or action class"
    ):
        type_hash(int)
    with pytest.raises(UnknownInterfaceError, match='no package'):
        type_hash('nowhere_msgs/msg/Foo')


def test_an_unknown_nested_type_has_no_hash() -> None:
    package = fresh_package()
    register_definitions(package, {'msg/Foo': 'nowhere_msgs/Bar bar'})
    with pytest.raises((UnknownInterfaceError, InterfaceSyntaxError), match='nowhere_msgs'):
        type_hash(f'{package}/msg/Foo')


@pytest.mark.parametrize(
    ('type_name', 'expected'),
    [
        ('std_msgs/msg/String', False),
        ('std_msgs/msg/UInt8MultiArray', True),
        ('sensor_msgs/msg/Image', True),
        ('sensor_msgs/msg/Imu', False),  # fixed arrays only
        ('trajectory_msgs/msg/JointTrajectory', True),  # inside its points
        ('nav_msgs/msg/Path', False),  # a sequence of messages
        ('shape_msgs/msg/SolidPrimitive', False),  # its sequence is bounded; its polygon has points only
    ],
)
def test_buffer_fields_are_unbounded_sequences_of_primitives(type_name: str, expected: bool) -> None:
    cls: Any = get_message(type_name)
    assert has_buffer_fields(cls) is expected
