"""ROS 2's names on DDS, and what endpoints say of themselves."""

from __future__ import annotations

import pytest

from goalwire.transport.dds.description import (
    EndpointData,
    Role,
    TopicName,
    dds_topic,
    dds_type,
    decode_endpoint,
    enclave_of,
    encode_endpoint,
    encode_participant,
    ros_topic,
    ros_type,
    service_id,
)

TOPICS = [
    (Role.TOPIC, '/chatter', 'rt/chatter'),
    (Role.TOPIC, '/a/b/c', 'rt/a/b/c'),
    (Role.REQUEST, '/add', 'rq/addRequest'),
    (Role.REPLY, '/add', 'rr/addReply'),
    (Role.REQUEST, '/fib/_action/send_goal', 'rq/fib/_action/send_goalRequest'),
    (Role.REPLY, '/fib/_action/get_result', 'rr/fib/_action/get_resultReply'),
]
TYPES = [
    (Role.TOPIC, 'std_msgs/msg/String', 'std_msgs::msg::dds_::String_'),
    (Role.TOPIC, 'a_b/action/Fibonacci_FeedbackMessage', 'a_b::action::dds_::Fibonacci_FeedbackMessage_'),
    (Role.REQUEST, 'pkg/srv/AddTwoInts', 'pkg::srv::dds_::AddTwoInts_Request_'),
    (Role.REPLY, 'pkg/srv/AddTwoInts', 'pkg::srv::dds_::AddTwoInts_Response_'),
    (Role.REPLY, 'pkg/action/Walk_SendGoal', 'pkg::action::dds_::Walk_SendGoal_Response_'),
]


@pytest.mark.parametrize(('role', 'name', 'topic'), TOPICS)
def test_a_name_becomes_a_topic_and_comes_back(role: Role, name: str, topic: str) -> None:
    assert dds_topic(role, name) == topic
    assert ros_topic(topic) == TopicName(role, name)


@pytest.mark.parametrize(('role', 'type_name', 'on_dds'), TYPES)
def test_a_type_becomes_a_dds_type_and_comes_back(role: Role, type_name: str, on_dds: str) -> None:
    assert dds_type(role, type_name) == on_dds
    assert ros_type(role, on_dds) == type_name


def test_without_ros_2s_conventions_the_prefix_is_left_out_and_the_suffix_stays() -> None:
    assert dds_topic(Role.TOPIC, '/chatter', verbatim=True) == '/chatter'
    assert dds_topic(Role.REQUEST, '/add', verbatim=True) == '/addRequest'
    assert ros_topic('/chatter') == TopicName(Role.TOPIC, '/chatter')


@pytest.mark.parametrize(
    'topic', ['ros_discovery_info', 'DCPSParticipant', 'rx/chatter', 'rq/add', 'rr/addRequest', 'rt/', '']
)
def test_what_is_no_topic_of_ros_2_has_no_name_there(topic: str) -> None:
    assert ros_topic(topic) is None


@pytest.mark.parametrize('type_name', ['HelloWorld', 'pkg::msg::String_', 'pkg::msg::dds_::String', ''])
def test_a_type_that_is_not_ros_2s_keeps_its_name(type_name: str) -> None:
    assert ros_type(Role.TOPIC, type_name) == type_name


HASH = f'RIHS01_{"a1" * 32}'


def test_a_participant_names_its_enclave() -> None:
    assert encode_participant('/') == b'enclave=/;'
    assert enclave_of(b'enclave=/robot/arm;') == '/robot/arm'


def test_a_participant_without_an_enclave_has_the_empty_one() -> None:
    assert enclave_of(b'') == ''


@pytest.mark.parametrize(
    ('data', 'raw'),
    [
        (EndpointData(HASH), f'typehash={HASH};'),
        (EndpointData(HASH, service_id='1.2'), f'serviceid=1.2;typehash={HASH};'),
        (EndpointData(HASH, client_id='1.2'), f'clientid=1.2;typehash={HASH};'),
        (EndpointData(HASH, client_id='1', takes_refusals=True), f'clientid=1;typehash={HASH};goalwire=1;'),
    ],
)
def test_an_endpoint_says_what_it_is_in_ros_2s_order(data: EndpointData, raw: str) -> None:
    assert encode_endpoint(data) == raw.encode()
    assert decode_endpoint(raw.encode()) == data


@pytest.mark.parametrize('raw', [b'', b';;', b'typehash', b'\xff\xfe', b'other=thing;'])
def test_what_cannot_be_read_counts_as_not_said(raw: bytes) -> None:
    assert decode_endpoint(raw) == EndpointData()


def test_an_id_is_sixteen_bytes_in_hex_without_zeros_the_first_in_two_columns() -> None:
    guid = bytes([0x01, 0x10, 0xAB, 0, 5, 6, 7, 8, 9, 10, 11, 12, 0, 0, 1, 0xC1])
    assert service_id(guid, 258) == ' 1.10.ab.0.5.6.7.8.9.a.b.c.0.0.1.2'


@pytest.mark.parametrize('hostile', ['x\n[INFO] [1] [a]: forged', '\x1b[2J', 'a\u202eb'])
def test_what_no_log_can_show_counts_as_not_said(hostile: str) -> None:
    raw = f'typehash={hostile};serviceid=1.2;enclave={hostile};'.encode()
    assert decode_endpoint(raw) == EndpointData('', service_id='1.2')
    assert enclave_of(raw) == ''
