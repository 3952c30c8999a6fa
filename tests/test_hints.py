"""The remedies for errors that Python itself raises."""

from __future__ import annotations

import pytest
from std_srvs.srv import SetBool

from goalwire.hints import hint_for


@pytest.mark.parametrize(
    ('kind', 'hint'),
    [('Response', 'SetBool_Response has the fields success, message'), ('Request', 'has the fields data')],
)
def test_a_field_that_a_message_lacks_is_answered_with_its_fields(kind: str, hint: str) -> None:
    assert hint in hint_for(_read_battery(getattr(SetBool, kind)()))


def test_a_field_of_an_inner_message_is_answered_with_the_way_to_it() -> None:
    from example_interfaces.action import Fibonacci

    message = Fibonacci.Impl.FeedbackMessage()
    with pytest.raises(AttributeError) as caught:
        message.sequence  # type: ignore[attr-defined]  # noqa: B018
    assert hint_for(caught.value) == (
        'Fibonacci_FeedbackMessage has the fields goal_id, feedback; write .feedback.sequence'
    )


def test_a_callback_that_a_node_lacks_may_be_a_method() -> None:
    import rclpy
    from rclpy.node import Node

    class Lamp(Node):
        pass

    rclpy.init()
    try:
        with pytest.raises(AttributeError) as caught:
            Lamp('lamp').switch  # type: ignore[attr-defined]  # noqa: B018
        assert "or a method 'def switch(self, …)'" in hint_for(caught.value)
    finally:
        rclpy.shutdown()


def test_a_message_without_fields_says_so() -> None:
    from std_srvs.srv import Trigger

    assert hint_for(_read_battery(Trigger.Request())) == 'Trigger_Request has no fields'


def _read_battery(message: object) -> AttributeError:
    with pytest.raises(AttributeError) as caught:
        message.battery  # type: ignore[attr-defined]  # noqa: B018
    return caught.value
