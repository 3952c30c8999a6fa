"""Keys, against the examples of rmw_zenoh's design."""

from __future__ import annotations

import pytest

from goalwire.errors import TransportError
from goalwire.transport.zenoh.keyexpr import data_key, dds_type, graph_key, ros_type

STRING_HASH = 'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18'
ADD_HASH = 'RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a'


@pytest.mark.parametrize(
    ('domain', 'name', 'type_name', 'type_hash', 'key'),
    [
        (
            0,
            '/chatter',
            'std_msgs/msg/String',
            STRING_HASH,
            f'0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}',
        ),
        (
            0,
            '/robot1/chatter',
            'std_msgs/msg/String',
            STRING_HASH,
            f'0/robot1/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}',
        ),
        (
            2,
            '/add_two_ints',
            'example_interfaces/srv/AddTwoInts',
            ADD_HASH,
            f'2/add_two_ints/example_interfaces::srv::dds_::AddTwoInts_/{ADD_HASH}',
        ),
        (
            0,
            '/fib/_action/send_goal',
            'pkg/action/Fib_SendGoal',
            'RIHS01_1',
            '0/fib/_action/send_goal/pkg::action::dds_::Fib_SendGoal_/RIHS01_1',
        ),
    ],
)
def test_a_key_is_domain_name_type_and_hash(
    domain: int, name: str, type_name: str, type_hash: str, key: str
) -> None:
    assert data_key(domain, name, type_name, type_hash) == key


def test_one_slash_at_either_end_of_a_name_is_dropped() -> None:
    assert data_key(0, '/a/b/', 'p/msg/T', 'h').startswith('0/a/b/p::msg')


@pytest.mark.parametrize('name', ['//a', '/a//b', '/a*', '/a#', '/a?', '/$a', '/a b', ''])
def test_a_name_that_zenoh_cannot_carry_is_refused_by_name(name: str) -> None:
    with pytest.raises(TransportError, match='cannot travel over Zenoh') as caught:
        data_key(0, name, 'p/msg/T', 'h')
    assert repr(name) in str(caught.value)


@pytest.mark.parametrize('type_name', ['std_msgs/msg/String', 'pkg/srv/Add', 'pkg/action/Fib_GetResult'])
def test_a_type_survives_its_dds_spelling(type_name: str) -> None:
    assert ros_type(dds_type(type_name)) == type_name


@pytest.mark.parametrize('spelling', ['String', 'std_msgs::msg::String_', 'std_msgs::msg::dds_::String'])
def test_a_spelling_that_is_not_dds_is_shown_as_it_is(spelling: str) -> None:
    assert ros_type(spelling) == spelling


def test_the_graph_of_a_domain_is_one_expression() -> None:
    assert graph_key(7) == '@ros2_lv/7/**'
