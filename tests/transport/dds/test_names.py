"""Names on DDS, held to those of rmw_cyclonedds."""

from __future__ import annotations

import pytest

from goalwire.transport.dds.names import Role, TopicName, dds_topic, dds_type, ros_topic, ros_type

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
