"""rclpy.experimental.EventsExecutor: the surface of every executor."""

from __future__ import annotations

import pytest
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spinner, result_of
from rclpy.context import Context
from rclpy.executors import Executor, ShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.experimental.events_executor import EventsExecutor as SameExecutor
from std_srvs.srv import Trigger


def test_it_runs_timers_services_clients_and_tasks(make_node: MakeNode, context: Context) -> None:
    assert EventsExecutor is SameExecutor
    node, ticks = make_node(), Collector[int]()
    node.create_service(Trigger, 'answer', lambda _, response: response)
    client = node.create_client(Trigger, 'answer')
    node.create_timer(0.001, lambda: ticks(1))
    with EventsExecutor(context=context) as executor, Spinner(executor, node):
        assert isinstance(executor, Executor)
        assert result_of(client.call_async(Trigger.Request())) == Trigger.Response()
        ticks.expect(3)
        assert result_of(executor.create_task(lambda: 5)) == 5
        assert executor.get_nodes() == [node]


def test_it_spins_until_a_future_is_done(make_node: MakeNode, context: Context) -> None:
    node = make_node()
    node.create_service(Trigger, 'answer', lambda _, response: response)
    client = node.create_client(Trigger, 'answer')
    executor = EventsExecutor(context=context)
    executor.add_node(node)
    answer = client.call_async(Trigger.Request())
    executor.spin_until_future_complete(answer, timeout_sec=PATIENCE)
    assert answer.done()
    executor.shutdown()
    with pytest.raises(ShutdownException, match='make a new one'):
        executor.add_node(node)
