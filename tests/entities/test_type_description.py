"""The descriptions of types are rosidl's; their sources are the files' own text."""

from __future__ import annotations

import hashlib
import json
from typing import Any

import pytest
from helpers.names import fresh_package
from helpers.vectors import WORKSPACE, descriptions
from type_description_interfaces.msg import IndividualTypeDescription, TypeDescription

from goalwire.entities.type_description import described, sources
from goalwire.idl import register_definitions, type_hash


def fields(description: IndividualTypeDescription) -> list[dict[str, Any]]:
    return [
        {
            'name': field.name,
            'type_id': field.type.type_id,
            'capacity': field.type.capacity,
            'string_capacity': field.type.string_capacity,
            'nested_type_name': field.type.nested_type_name,
            'default': field.default_value,
        }
        for field in description.fields
    ]


def hash_of(description: TypeDescription) -> str:
    """Return the hash that who gets a description makes of it."""

    def plain(item: IndividualTypeDescription) -> dict[str, object]:
        return {
            'type_name': item.type_name,
            'fields': [
                {
                    'name': field.name,
                    'type': {
                        'type_id': field.type.type_id,
                        'capacity': field.type.capacity,
                        'string_capacity': field.type.string_capacity,
                        'nested_type_name': field.type.nested_type_name,
                    },
                }
                for field in item.fields
            ],
        }

    text = json.dumps(
        {
            'type_description': plain(description.type_description),
            'referenced_type_descriptions': [
                plain(item) for item in description.referenced_type_descriptions
            ],
        }
    )
    return f'RIHS01_{hashlib.sha256(text.encode()).hexdigest()}'


def test_fields_types_and_defaults_are_those_of_ros_2(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_INTERFACE_PATH', str(WORKSPACE))
    missing = {'capacity': 0, 'string_capacity': 0, 'nested_type_name': '', 'default': ''}
    for type_name in (
        'control_msgs/msg/MotionPrimitive',
        'geometry_msgs/msg/Quaternion',
        'rcl_interfaces/msg/ParameterDescriptor',
        'sensor_msgs/msg/NavSatStatus',
        'std_srvs/srv/SetBool',
        'example_interfaces/action/Fibonacci',
    ):
        wanted = [{**missing, **field} for field in descriptions()[type_name]]
        assert fields(described(type_name).type_description) == wanted, type_name


def test_default_values_are_written_as_rosidl_writes_them() -> None:
    package = fresh_package()
    text = 'bool b true\nbyte y 7\nint32 i -5\nfloat32 f 1\nstring s "say \'hi\'"\nint32[3] a [1, 2, 3]'
    register_definitions(package, {'msg/Foo': text})
    (individual,) = [described(f'{package}/msg/Foo').type_description]
    assert [field.default_value for field in individual.fields] == [
        'True',
        '7',
        '-5',
        '1.0',
        "say 'hi'",
        '(1, 2, 3)',
    ]


@pytest.mark.parametrize(
    'type_name',
    ['std_msgs/msg/Header', 'std_srvs/srv/Trigger', 'example_interfaces/action/Fibonacci_SendGoal'],
)
def test_the_hash_follows_from_the_description(type_name: str) -> None:
    assert hash_of(described(type_name)) == type_hash(type_name)


def test_sources_are_the_texts_of_the_type_and_of_all_in_it() -> None:
    package = fresh_package()
    register_definitions(
        package,
        {'msg/Inner': 'int32 x  # [m]\n', 'srv/Ask': f'{package}/Inner inner\n---\nbool ok\n'},
    )
    found = {
        source.type_name: (source.encoding, source.raw_file_contents)
        for source in sources(f'{package}/srv/Ask')
    }
    assert found[f'{package}/srv/Ask'] == ('srv', f'{package}/Inner inner\n---\nbool ok\n')
    assert found[f'{package}/msg/Inner'] == ('msg', 'int32 x  # [m]\n')
    assert found[f'{package}/srv/Ask_Request'] == ('implicit', '')
    assert next(iter(found)) == f'{package}/srv/Ask'
