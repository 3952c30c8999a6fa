"""What the entities know of interface classes."""

from __future__ import annotations

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


@pytest.mark.parametrize('wrong', [int, object, 'text', 5], ids=repr)
def test_what_is_no_interface_is_refused(wrong: type) -> None:
    for support in (message_support, service_support, action_support):
        with pytest.raises(AttributeError, match=r"has no attribute '_TYPE_SUPPORT' This might be a ROS 1"):
            support(wrong)


def test_interfaces_of_another_kind_are_refused() -> None:
    with pytest.raises(RuntimeError, match='message type provided is not valid'):
        message_support(Trigger)
    with pytest.raises(RuntimeError, match='service type provided is not valid'):
        service_support(String)
    with pytest.raises(RuntimeError, match='action type provided is not valid'):
        action_support(Trigger)
