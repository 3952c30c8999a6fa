"""rclpy.init, ok, shutdown and the functions that spin."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import partial
from typing import Any

import pytest
import rclpy
import rclpy.utilities
from helpers.collector import Collector
from helpers.isolation import fresh_domain
from helpers.patience import PATIENCE
from helpers.processes import Program
from rclpy.context import Context
from rclpy.exceptions import NotInitializedException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions, get_current_signal_handlers_options
from rclpy.task import Future

from goalwire.errors import RCLError, UnknownROSArgsError


@pytest.fixture(autouse=True)
def clean(isolated: dict[str, str]) -> Iterator[None]:
    """An isolated world, and no default context left."""
    assert not rclpy.ok()
    yield
    rclpy.try_shutdown()
    rclpy.uninstall_signal_handlers()


def test_before_init_nothing_is_there() -> None:
    assert rclpy.ok() is False
    text = r'^rclpy\.init\(\) has not been called\. msg:cannot create node\n'
    with pytest.raises(NotInitializedException, match=text):
        Node('a')
    with pytest.raises(NotInitializedException, match=text):
        rclpy.create_node('a')
    with pytest.raises(RuntimeError, match=r'^Context must be initialized before it can be shutdown$'):
        rclpy.shutdown()
    rclpy.try_shutdown()
    rclpy.utilities.try_shutdown()
    context = rclpy.utilities.get_default_context()
    assert not context.ok()
    with pytest.raises(RuntimeError, match=r'^Context must be initialized before it can have a domain id$'):
        context.get_domain_id()


def test_init_and_shutdown(isolated: dict[str, str]) -> None:
    rclpy.init(args=[])
    assert rclpy.ok()
    with pytest.raises(
        RuntimeError, match=r'^Context\.init\(\) must only be called once; .*call rclpy.shutdown\(\) first'
    ):
        rclpy.init(args=[])
    assert rclpy.get_default_context().get_domain_id() == int(isolated['ROS_DOMAIN_ID'])
    assert type(rclpy.get_global_executor()) is SingleThreadedExecutor
    rclpy.shutdown()
    assert not rclpy.ok()
    with pytest.raises(RuntimeError, match='must be initialized'):
        rclpy.shutdown()


def test_init_works_again_after_shutdown() -> None:
    for number in range(3):
        rclpy.init(args=[])
        node = rclpy.create_node(f'node{number}')
        node.create_timer(0, lambda: None)
        rclpy.spin_once(node, timeout_sec=PATIENCE)
        assert rclpy.get_global_executor() is node.executor
        rclpy.shutdown()
        node.destroy_node()


def test_a_node_keeps_its_names_after_shutdown() -> None:
    rclpy.init(args=[])
    node = Node('a')
    rclpy.shutdown()
    assert node.get_name() == 'a'
    assert node.get_fully_qualified_name() == '/a'
    assert node.get_clock().now().nanoseconds > 0
    with pytest.raises(RCLError, match='the context was shut down'):
        node.get_topic_names_and_types()
    node.destroy_node()


def test_leaving_the_block_shuts_down() -> None:
    with rclpy.init(args=[]) as opened:
        assert opened.context is rclpy.get_default_context()
        assert rclpy.ok()
        assert get_current_signal_handlers_options() is SignalHandlerOptions.ALL
    assert not rclpy.ok()
    assert get_current_signal_handlers_options() is SignalHandlerOptions.NO


def test_a_block_may_come_after_another() -> None:
    for _ in range(2):
        with rclpy.init(args=[]) as opened:
            assert rclpy.create_node('a').context is opened.context
    with rclpy.init(args=[]):
        rclpy.shutdown()
        rclpy.init(args=[])
    assert rclpy.ok(), 'a block ends its own context alone'


def test_the_program_s_own_arguments_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setattr(sys, 'argv', ['prog', '--ros-args', '-r', '__node:=renamed'])
    rclpy.init()
    node = Node('a')
    assert node.get_name() == 'renamed'
    node.destroy_node()


BAD = {
    'foo:=': r"Couldn't parse remap rule: '-r foo:='",
    '__ns:=x': r"Couldn't parse remap rule: '-r __ns:=x'",
    '__node:=a b': r"Couldn't parse remap rule: '-r __node:=a b'",
    'topic:=bad name': r"Couldn't parse remap rule: '-r topic:=bad name'",
}


@pytest.mark.parametrize('rule', BAD)
def test_a_bad_remap_rule_is_refused(rule: str) -> None:
    with pytest.raises(RCLError, match=f'^failed to initialize rcl: {BAD[rule]}. Error: '):
        rclpy.init(args=['--ros-args', '-r', rule])
    assert not rclpy.ok()


@pytest.mark.parametrize(
    ('args', 'text'),
    [
        (['--log-level', 'nope'], r"Couldn't parse log level: '--log-level nope'"),
        (['-p', 'novalue'], r"Couldn't parse parameter override rule: '-p novalue'"),
        (['-p', 'a:='], r"Couldn't parse parameter override rule: '-p a:='"),
    ],
)
def test_other_bad_arguments_are_refused(args: list[str], text: str) -> None:
    with pytest.raises(RCLError, match=f'^failed to initialize rcl: {text}'):
        rclpy.init(args=['--ros-args', *args])


def test_unknown_arguments_are_refused() -> None:
    with pytest.raises(UnknownROSArgsError, match='bad'):
        rclpy.init(args=['x', '--ros-args', '-p', 'a:=1', '--ros-args', 'bad'])


@pytest.mark.parametrize(
    'args', ['abc', [1], [None], 5, {'a': 1}, iter(['a'])], ids=lambda args: type(args).__name__
)
def test_arguments_are_strings(args: Any) -> None:
    with pytest.raises(TypeError, match='sequence of strings'):
        rclpy.init(args=args)


def test_bytes_that_are_no_text_do_not_matter_to_a_program_and_are_told_of_to_ros() -> None:
    with rclpy.init(args=['prog', 'caf\udce9', '--ros-args', '-r', '__node:=n']):  # PEP 383: b'caf\xe9'
        assert Node('other').get_name() == 'n'
    with pytest.raises(RCLError, match=r'the bytes are not UTF-8 text'):
        rclpy.init(args=['--ros-args', '-p', 's:=caf\udce9'])
    with pytest.raises(RCLError, match=r"Couldn't parse remap rule: '-r __ns:=/caf"):
        rclpy.init(args=['--ros-args', '-r', '__ns:=/caf\udce9'])


def test_a_negative_domain_is_refused() -> None:
    with pytest.raises(RuntimeError, match=r'^Domain id \(-1\) should not be lower than zero\.$'):
        rclpy.init(args=[], domain_id=-1)


def test_a_domain_that_is_no_number_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', 'seven')
    with pytest.raises(RCLError, match="ROS_DOMAIN_ID is not an integral number: it is 'seven'"):
        rclpy.init(args=[])


def test_a_context_of_ones_own_leaves_the_default_one_and_its_handlers_alone() -> None:
    rclpy.init(args=[])
    context = Context()
    rclpy.init(args=[], context=context, domain_id=fresh_domain())
    assert get_current_signal_handlers_options() is SignalHandlerOptions.ALL
    node = rclpy.create_node('own', context=context)
    assert rclpy.ok(context=context)
    rclpy.shutdown(context=context)
    assert not rclpy.ok(context=context)
    assert rclpy.ok()
    assert get_current_signal_handlers_options() is SignalHandlerOptions.ALL
    node.destroy_node()


# -- spinning --------------------------------------------------------------------------------------------


def test_spin_once_runs_one_callback() -> None:
    rclpy.init(args=[])
    node, called = Node('a'), list[int]()
    for number in range(2):
        node.create_guard_condition(partial(called.append, number)).trigger()
    rclpy.spin_once(node, timeout_sec=PATIENCE)
    assert called == [0]
    rclpy.spin_once(node, timeout_sec=PATIENCE)
    assert called == [0, 1]
    rclpy.spin_once(node, timeout_sec=0.01)
    assert called == [0, 1]
    node.destroy_node()


def test_before_init_and_after_shutdown_there_is_nothing_to_spin() -> None:
    context = Context()
    context.init([])
    node = Node('own', context=context)
    with pytest.raises(NotInitializedException, match='cannot spin'):
        rclpy.spin(node)
    rclpy.init(args=[])
    rclpy.shutdown()
    with pytest.raises(NotInitializedException, match='cannot spin'):
        rclpy.spin_once(node, timeout_sec=0)
    context.shutdown()


def test_spin_until_future_complete_ends_in_time() -> None:
    rclpy.init(args=[])
    node, future = Node('a'), Future[int]()
    rclpy.spin_until_future_complete(node, future, timeout_sec=0.01)
    assert not future.done()
    node.create_timer(0.001, lambda: future.set_result(5))
    rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE)
    assert future.result() == 5
    assert node not in rclpy.get_global_executor().get_nodes()
    node.destroy_node()


@pytest.mark.parametrize('by_timer', [False, True], ids=['another thread', 'a callback'])
def test_shutdown_ends_spin(by_timer: bool) -> None:
    rclpy.init(args=[])
    node, ended = Node('a'), Collector[str]()
    rclpy.get_default_context().on_shutdown(lambda: ended('on_shutdown'))
    spinning = threading.Event()

    def callback() -> None:
        spinning.set()
        if by_timer:
            rclpy.shutdown()

    def stop() -> None:
        assert spinning.wait(PATIENCE)
        rclpy.shutdown()

    thread = threading.Thread(target=stop)
    if not by_timer:
        thread.start()
    node.create_timer(0.001, callback)
    rclpy.spin(node)
    if not by_timer:
        thread.join()  # as in rclpy: the executor's end, which ends the spin, comes before the context's
    assert not rclpy.ok()
    assert ended.items == ['on_shutdown']
    node.destroy_node()


def test_an_exception_comes_out_of_spin_and_spin_works_again() -> None:
    rclpy.init(args=[])
    node = Node('a')

    def callback() -> None:
        timer.cancel()
        raise ZeroDivisionError

    timer = node.create_timer(0.001, callback)
    with pytest.raises(ZeroDivisionError):
        rclpy.spin(node)
    node.create_timer(0.001, rclpy.shutdown)
    rclpy.spin(node)
    node.destroy_node()


def test_destroying_the_node_in_a_callback_leaves_spin_waiting() -> None:
    rclpy.init(args=[])
    node, destroyed = Node('a'), threading.Event()

    def callback() -> None:
        node.destroy_node()
        destroyed.set()

    node.create_timer(0.001, callback)

    def stop() -> None:
        assert destroyed.wait(PATIENCE)
        rclpy.shutdown()

    thread = threading.Thread(target=stop)
    thread.start()
    rclpy.spin(node)
    thread.join()


# -- light -----------------------------------------------------------------------------------------------


def test_a_node_with_services_and_actions_imports_nothing_heavy(isolated: dict[str, str]) -> None:
    program = """
        import sys
        import rclpy
        rclpy.init()
        from rclpy.node import Node
        from std_srvs.srv import Trigger
        node = Node('light')
        client = node.create_client(Trigger, 'go')
        def go(request, response):
            response.message = 'went'
            return response
        node.create_service(Trigger, 'go', go)
        assert client.wait_for_service(10)
        future = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(node, future, timeout_sec=10)
        assert future.result().message == 'went'
        from rclpy.action import ActionClient, ActionServer
        from example_interfaces.action import Fibonacci
        def count(goal):
            goal.publish_feedback(Fibonacci.Feedback(sequence=[1]))
            goal.succeed()
            return Fibonacci.Result(sequence=[1, 1])
        server = ActionServer(node, Fibonacci, 'count', count)
        actions = ActionClient(node, Fibonacci, 'count')
        assert actions.wait_for_server(10)
        heard = []
        future = actions.send_goal_async(Fibonacci.Goal(order=2), feedback_callback=heard.append)
        rclpy.spin_until_future_complete(node, future, timeout_sec=10)
        future = future.result().get_result_async()
        rclpy.spin_until_future_complete(node, future, timeout_sec=10)
        assert list(future.result().result.sequence) == [1, 1]
        assert [list(message.feedback.sequence) for message in heard] == [[1]]
        print([name for name in ('numpy', 'asyncio', 'yaml', 'rich') if name in sys.modules])
        rclpy.shutdown()
    """
    with Program(program, env=isolated) as running:
        assert running.succeed() == '[]'
