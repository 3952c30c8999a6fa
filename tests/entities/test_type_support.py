"""The facts that the entities know of interface classes."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from std_msgs.msg import String
from std_srvs.srv import Trigger

from goalwire.entities.type_support import action_support, message_support, service_support


def test_a_message() -> None:
    support = message_support(String)
    assert support is message_support(String)
    assert support.type_name == 'std_msgs/msg/String'
    assert support.type_hash == 'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18'
    assert support.decode(support.encode(String(data='x'))) == String(data='x')


def test_a_service() -> None:
    support = service_support(Trigger)
    assert (support.request, support.response) == (Trigger.Request, Trigger.Response)
    assert support.type_name == 'std_srvs/srv/Trigger'
    response = Trigger.Response(success=True, message='m')
    assert support.decode_response(support.encode_response(response)) == response


def test_an_action_is_three_services_and_two_messages() -> None:
    support = action_support(Fibonacci)
    assert support.send_goal.type_name == 'example_interfaces/action/Fibonacci_SendGoal'
    assert support.get_result.type_name == 'example_interfaces/action/Fibonacci_GetResult'
    assert support.cancel_goal.type_name == 'action_msgs/srv/CancelGoal'
    assert support.feedback.type_name == 'example_interfaces/action/Fibonacci_FeedbackMessage'
    assert support.status.type_name == 'action_msgs/msg/GoalStatusArray'


@pytest.mark.parametrize('wrong', [int, object, 5], ids=repr)
def test_what_is_no_interface_is_refused(wrong: type) -> None:
    for support in (message_support, service_support, action_support):
        with pytest.raises(AttributeError, match='This might be a ROS 1'):
            support(wrong)


def test_interfaces_of_another_kind_are_refused() -> None:
    with pytest.raises(RuntimeError, match='message type provided is not valid'):
        message_support(Trigger)
    with pytest.raises(RuntimeError, match='service type provided is not valid'):
        service_support(String)
    with pytest.raises(RuntimeError, match='action type provided is not valid'):
        action_support(Trigger)


@pytest.mark.parametrize(
    ('given', 'said'),
    [
        ('std_msgs.msg', 'std_msgs.msg is a module: give a class of it, such as std_msgs.msg.Bool'),
        ('std_msgs.msg._string', 'is a module: give a class of it, such as std_msgs.msg.String'),
        ('std_srvs.srv._trigger', 'is a module: give a class of it, such as std_srvs.srv.Trigger'),
        ('std_msgs', 'std_msgs is a module: give a class of it'),
        ('json', 'json is a module: give a class of it'),
    ],
)
@pytest.mark.parametrize('support', [message_support, service_support, action_support])
def test_a_module_in_the_place_of_a_type_is_told_what_to_give(
    support: Callable[[Any], object], given: str, said: str
) -> None:
    with pytest.raises(AttributeError, match=re.escape(said)):
        support(importlib.import_module(given))


def test_a_message_or_a_name_in_the_place_of_a_type_is_told_what_to_give() -> None:
    given: Any = String()
    with pytest.raises(TypeError, match=r'of type String: give the class itself, String without \(\)'):
        message_support(given)
    name: Any = 'std_msgs/msg/String'
    with pytest.raises(AttributeError, match=r"get_interface\('std_msgs/msg/String'\) returns"):
        message_support(name)
