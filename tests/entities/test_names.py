"""Names with rclpy's exceptions, and what an action's name becomes."""

from __future__ import annotations

import pytest

from goalwire.entities.names import resolve_action_names
from goalwire.errors import InvalidTopicNameException
from goalwire.rules.names import RemapRules, parse_remap_rule
from goalwire.transport.contract import NodeName

NODE = NodeName('nn', '/ns')


def rules(*texts: str) -> RemapRules:
    return RemapRules(tuple(parse_remap_rule(text) for text in texts))


def test_an_action_has_five_parts() -> None:
    assert resolve_action_names('fib', NODE, rules()) == (
        '/ns/fib',
        '/ns/fib/_action/send_goal',
        '/ns/fib/_action/cancel_goal',
        '/ns/fib/_action/get_result',
        '/ns/fib/_action/feedback',
        '/ns/fib/_action/status',
    )


def test_the_name_of_an_action_is_remapped_with_all_its_parts() -> None:
    found = resolve_action_names('fib', NODE, rules('fib:=/robot/count'))
    assert found.name == '/robot/count'
    assert all(part.startswith('/robot/count/_action/') for part in found[1:])


def test_parts_may_be_remapped_one_by_one() -> None:
    """Users of Jazzy write such rules, since Jazzy does not remap the name."""
    parts = ('send_goal', 'cancel_goal', 'get_result', 'feedback', 'status')
    one_by_one = rules(*(f'fib/_action/{part}:=/count/_action/{part}' for part in parts))
    found = resolve_action_names('fib', NODE, one_by_one)
    assert found == resolve_action_names('/count', NODE, rules())


@pytest.mark.parametrize('name', ['', 'a b', '1a', 'a//b', 'a/'])
def test_a_bad_action_name_is_refused(name: str) -> None:
    with pytest.raises(InvalidTopicNameException):
        resolve_action_names(name, NODE, rules())
