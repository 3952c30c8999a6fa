from __future__ import annotations

import pytest
from helpers.execution import SmallNode

from goalwire.errors import InvalidHandle
from goalwire.execution.event_queue import GuardCondition
from goalwire.execution.single_threaded import SingleThreadedExecutor


def test_triggers_before_the_callback_count_as_one(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    ran: list[int] = []
    guard = GuardCondition(lambda: ran.append(1), None, work_queue=node.work_queue)
    guard.trigger()
    guard.trigger()
    single.spin_once(0)
    single.spin_once(0)
    assert ran == [1]
    guard.trigger()
    single.spin_once(0)
    assert ran == [1, 1]


def test_a_destroyed_one_raises_invalid_handle_and_runs_nothing(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    single.add_node(node)
    ran: list[int] = []
    guard = GuardCondition(lambda: ran.append(1), None, work_queue=node.work_queue)
    guard.trigger()
    guard.destroy()
    single.spin_once(0)
    assert ran == []
    with pytest.raises(InvalidHandle):
        guard.trigger()
    with pytest.raises(InvalidHandle):
        _ = guard.handle


def test_one_without_a_callback_is_harmless(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    GuardCondition(None, None, work_queue=node.work_queue).trigger()
    single.spin_once(0)
    assert not single._ready.items
