"""Types that are known from another node's description alone."""

from __future__ import annotations

import pytest
from type_description_interfaces.msg import Field, FieldType, IndividualTypeDescription, TypeDescription

from goalwire.cdr.type_hash import hash_of_description
from goalwire.entities.type_description import described
from goalwire.errors import InterfaceError
from goalwire.idl import registry, type_hash
from goalwire.idl.descriptions import register_descriptions


def _renamed(description: TypeDescription, package: str, other: str) -> TypeDescription:
    """Return a description as a node would send it whose package is not known here."""
    for one in (description.type_description, *description.referenced_type_descriptions):
        one.type_name = one.type_name.replace(f'{package}/', f'{other}/')
        for field in one.fields:
            field.type.nested_type_name = field.type.nested_type_name.replace(f'{package}/', f'{other}/')
    description.referenced_type_descriptions.sort(key=lambda each: each.type_name)
    return description


def _without_defaults(description: TypeDescription) -> TypeDescription:
    for one in (description.type_description, *description.referenced_type_descriptions):
        for field in one.fields:
            field.default_value = ''
    return description


@pytest.mark.parametrize(
    ('name', 'package'),
    [
        ('sensor_msgs/msg/JointState', 'sensor_msgs'),
        ('sensor_msgs/msg/PointCloud2', 'sensor_msgs'),
        ('std_srvs/srv/Empty', 'std_srvs'),
        ('rcl_interfaces/srv/SetParameters', 'rcl_interfaces'),
        ('control_msgs/action/FollowJointTrajectory', 'control_msgs'),
        ('rcl_interfaces/msg/ParameterDescriptor', 'rcl_interfaces'),
    ],
)
def test_a_description_becomes_the_type_that_it_describes(name: str, package: str) -> None:
    other = f'away_{name.rpartition("/")[2].lower()}'
    sent = _renamed(described(name), package, other)
    own = name.replace(f'{package}/', f'{other}/')
    assert own in register_descriptions(own, [sent])
    assert _without_defaults(described(own)) == _without_defaults(sent)
    assert type_hash(own).startswith('RIHS01_')


@pytest.mark.parametrize(
    'name', ['sensor_msgs/msg/PointCloud2', 'std_srvs/srv/Empty', 'example_interfaces/action/Fibonacci']
)
def test_a_description_has_the_hash_of_its_type(name: str) -> None:
    assert hash_of_description(described(name)) == type_hash(name)


def test_a_type_that_is_known_here_stays_as_it_is() -> None:
    before = registry.definition('std_msgs/msg/Header')
    assert register_descriptions('std_msgs/msg/Header', [described('std_msgs/msg/Header')]) == []
    assert registry.definition('std_msgs/msg/Header') is before


@pytest.mark.parametrize('number', [0, 14, 48, 200])
def test_a_number_that_no_type_has_is_refused(number: int) -> None:
    field = Field(name='x', type=FieldType(type_id=number))
    description = TypeDescription(
        type_description=IndividualTypeDescription(type_name='away_odd/msg/Odd', fields=[field])
    )
    with pytest.raises(InterfaceError, match=f'type number {number}, which is unknown'):
        register_descriptions(description.type_description.type_name, [description])


def test_a_service_without_a_response_is_refused() -> None:
    field = Field(
        name='request_message', type=FieldType(type_id=1, nested_type_name='away_half/srv/Half_Request')
    )
    request = IndividualTypeDescription(type_name='away_half/srv/Half_Request')
    description = TypeDescription(
        type_description=IndividualTypeDescription(type_name='away_half/srv/Half', fields=[field]),
        referenced_type_descriptions=[request],
    )
    with pytest.raises(InterfaceError, match='has no away_half/srv/Half_Response'):
        register_descriptions(description.type_description.type_name, [description])


def test_an_action_is_known_by_its_parts() -> None:
    parts = ('Fibonacci_SendGoal', 'Fibonacci_GetResult', 'Fibonacci_FeedbackMessage')
    sent = [
        _renamed(described(f'example_interfaces/action/{part}'), 'example_interfaces', 'away_parts')
        for part in parts
    ]
    assert register_descriptions('away_parts/action/Fibonacci', sent) == ['away_parts/action/Fibonacci']
    for part, description in zip(parts, sent, strict=True):
        assert described(f'away_parts/action/{part}') == description


def test_a_name_that_leads_elsewhere_is_refused() -> None:
    description = TypeDescription(type_description=IndividualTypeDescription(type_name='../etc/msg/X'))
    with pytest.raises(InterfaceError, match='not an interface name'):
        register_descriptions(description.type_description.type_name, [description])
