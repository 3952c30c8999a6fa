from __future__ import annotations

import pytest
from rclpy.qos import QoSProfile, qos_profile_unknown
from rclpy.topic_endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum
from rclpy.type_hash import TypeHash

pytestmark = pytest.mark.also_on_dds


def test_an_endpoint_is_printed_as_ros2_topic_info_does() -> None:
    info = TopicEndpointInfo(
        node_name='talker',
        node_namespace='/demo',
        topic_type='std_msgs/msg/String',
        topic_type_hash=TypeHash(1, bytes(32)),
        endpoint_type=TopicEndpointTypeEnum.PUBLISHER,
        endpoint_gid=[1, 2, 255],
        qos_profile=QoSProfile(depth=3),
    )
    assert str(info).splitlines() == [
        'Node name: talker',
        'Node namespace: /demo',
        'Topic type: std_msgs/msg/String',
        'Topic type hash: RIHS01_' + '0' * 64,
        'Endpoint type: PUBLISHER',
        'GID: 01.02.ff',
        'QoS profile:',
        '  Reliability: RELIABLE',
        '  History (Depth): KEEP_LAST (3)',
        '  Durability: VOLATILE',
        '  Lifespan: 0 nanoseconds',
        '  Deadline: 0 nanoseconds',
        '  Liveliness: SYSTEM_DEFAULT',
        '  Liveliness lease duration: 0 nanoseconds',
    ]


def test_what_is_not_given_is_unknown() -> None:
    info = TopicEndpointInfo()
    assert (info.node_name, info.node_namespace, info.topic_type, info.endpoint_gid) == ('', '', '', [])
    assert info.endpoint_type is TopicEndpointTypeEnum.INVALID
    assert info.topic_type_hash == TypeHash()
    assert info.qos_profile is qos_profile_unknown
    assert '  History (Depth): UNKNOWN\n' in str(info)


def test_parts_may_be_given_as_numbers_and_mappings() -> None:
    info = TopicEndpointInfo(
        endpoint_type=2, qos_profile={'depth': 3}, topic_type_hash={'version': 1, 'value': bytes(32)}
    )
    assert info.endpoint_type is TopicEndpointTypeEnum.SUBSCRIPTION
    assert info.qos_profile == QoSProfile(depth=3)
    assert info.topic_type_hash == TypeHash(1, bytes(32))


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('node_name', 1),
        ('node_namespace', None),
        ('topic_type', b'x'),
        ('topic_type_hash', 'x'),
        ('endpoint_type', 'x'),
        ('endpoint_gid', 5),
        ('endpoint_gid', ['a']),
        ('qos_profile', 1),
    ],
)
def test_a_value_of_another_type_is_refused_with_its_name(field: str, value: object) -> None:
    with pytest.raises(AssertionError, match=f'{field} must be'):
        TopicEndpointInfo(**{field: value})  # type: ignore[arg-type]


def test_an_unknown_field_is_refused() -> None:
    with pytest.raises(AssertionError, match='Invalid arguments passed to constructor: foo'):
        TopicEndpointInfo(foo=1)  # type: ignore[call-arg]


def test_endpoints_are_equal_by_value() -> None:
    assert TopicEndpointInfo(node_name='a') == TopicEndpointInfo(node_name='a')
    assert TopicEndpointInfo(node_name='a') != TopicEndpointInfo(node_name='b')
    assert TopicEndpointInfo() != 1
