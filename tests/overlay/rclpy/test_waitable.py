"""Waitables of a program's own, under both executors, on every kind of entity."""

from __future__ import annotations

import asyncio
import gc
import threading
import weakref
from collections.abc import Callable
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.actions import succeed
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, Spinner, result_of, wait_until
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType, ROSClock
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.experimental import AsyncNode
from rclpy.guard_condition import GuardCondition
from rclpy.node import Node
from rclpy.subscription import Subscription
from rclpy.task import Future
from rclpy.time import Time
from rclpy.timer import Timer
from rclpy.waitable import NumberOfEntities, Waitable
from std_msgs.msg import String
from std_srvs.srv import SetBool

from goalwire.execution.wait_sets.waitable import Kind, WaitablePoller, WaitSet

SECOND = 10**9


class Waits(Waitable[object]):
    """Waits for one entity, which `add` adds to a wait set, and hands what `take` takes to `taken`."""

    def __init__(
        self,
        kind: Kind,
        handle: Any,
        take: Callable[[], object] = lambda: 'taken',
        group: CallbackGroup | None = None,
    ) -> None:
        super().__init__(group or ReentrantCallbackGroup())
        self.kind: Kind = kind
        self.entity = handle
        self.take = take
        self.index = -1
        self.ready = False
        self.taken: Collector[object] = Collector()

    def get_num_entities(self) -> NumberOfEntities:
        return NumberOfEntities()

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        self.index = getattr(wait_set, f'add_{self.kind}')(self.entity)

    def is_ready(self, wait_set: WaitSet) -> bool:
        self.ready = wait_set.is_ready(self.kind, self.index)
        return self.ready

    def take_data(self) -> object:
        return self.take()

    async def execute(self, taken_data: object) -> None:
        self.taken(taken_data)


def added(node: Node, waits: Waits) -> Waits:
    node.add_waitable(waits)
    return waits


# -- what wakes it -------------------------------------------------------------------------------------------


def test_a_guard_condition_of_its_own_wakes_it(
    make_node: MakeNode, executor: Executor, context: Context
) -> None:
    node = make_node()
    guard = GuardCondition(None, None, context)
    waits = added(node, Waits('guard_condition', guard.handle))
    with Spinner(executor, node):
        for count in (1, 2, 3):
            guard.trigger()
            waits.taken.expect(count, PATIENCE)


def test_it_runs_once_for_each_trigger_and_not_without_one(make_node: MakeNode, executor: Executor) -> None:
    node = make_node()
    guard = node.create_guard_condition(None)
    waits = added(node, Waits('guard_condition', guard.handle))
    with Spinner(executor, node):
        guard.trigger()
        waits.taken.expect(1, PATIENCE)
        result_of(executor.create_task(lambda: 'other work'))
        result_of(executor.create_task(lambda: 'more'))
    assert waits.taken.items == ['taken']


def test_what_came_before_it_was_added_counts(
    make_node: MakeNode, executor: Executor, context: Context
) -> None:
    node = make_node()
    guard = GuardCondition(None, None, context)
    guard.trigger()
    waits = added(node, Waits('guard_condition', guard.handle))
    with Spinner(executor, node):
        waits.taken.expect(1, PATIENCE)


def test_two_may_wait_for_one_guard_condition(make_node: MakeNode, executor: Executor) -> None:
    node = make_node()
    guard = node.create_guard_condition(None)
    both = [added(node, Waits('guard_condition', guard)) for _ in range(2)]
    with Spinner(executor, node):
        guard.trigger()
        for waits in both:
            waits.taken.expect(1, PATIENCE)


def test_a_timer_of_its_own_is_ready_until_the_call_is_noted(
    make_node: MakeNode, executor: Executor, context: Context
) -> None:
    node = make_node()
    timer = Timer(None, None, SECOND // 100, Clock(clock_type=ClockType.STEADY_TIME), context=context)
    waits = added(node, Waits('timer', timer.handle, timer.call_timer))
    with Spinner(executor, node):
        waits.taken.expect(3, PATIENCE)
    assert timer.time_since_last_call() < PATIENCE * SECOND


def test_a_timer_that_is_reset_wakes_it_again(
    make_node: MakeNode, executor: Executor, context: Context
) -> None:
    node = make_node()
    timer = Timer(None, None, 1000, Clock(clock_type=ClockType.STEADY_TIME), context=context, autostart=False)
    waits = added(node, Waits('timer', timer, timer.cancel))
    with Spinner(executor, node):
        for count in (1, 2):
            timer.reset()
            waits.taken.expect(count, PATIENCE)


def test_a_timer_follows_a_clock_that_is_set(
    make_node: MakeNode, executor: Executor, context: Context
) -> None:
    node, clock = make_node(), ROSClock()
    clock._set_ros_time_is_active(True)
    timer = Timer(None, None, SECOND, clock, context=context)
    waits = added(node, Waits('timer', timer, timer.call_timer))
    with Spinner(executor, node):
        for second in (1, 2):
            clock.set_ros_time_override(Time(seconds=second, clock_type=ClockType.ROS_TIME))
            waits.taken.expect(second, PATIENCE)


def test_a_subscription_of_a_node_that_nobody_spins_is_taken_from(
    make_node: MakeNode, executor: Executor
) -> None:
    node, quiet = make_node(), make_node('quiet')
    subscription: Subscription[String] = quiet.create_subscription(String, 'words', print, 10)

    def take() -> str:
        found = subscription.handle.take_message(String, False)
        assert found is not None
        message, info = found
        assert info['source_timestamp'] > 0
        return str(message.data)

    waits = added(node, Waits('subscription', subscription.handle, take))
    publisher = quiet.create_publisher(String, 'words', 10)
    with Spinner(executor, node):
        wait_until(node.context, lambda: publisher.get_subscription_count() == 1)
        publisher.publish(String(data='one'))
        publisher.publish(String(data='two'))
        taken = waits.taken.expect(2, PATIENCE)
    assert taken == ['one', 'two']
    assert subscription.take_message(String, raw=False) is None


def test_a_service_of_a_node_that_nobody_spins_is_answered_by_hand(
    make_node: MakeNode, executor: Executor
) -> None:
    node, quiet = make_node(), make_node('quiet')
    service = quiet.create_service(SetBool, 'switch', lambda _, response: response)

    def answer() -> None:
        request, header = service.handle.service_take_request(SetBool.Request)
        assert request is not None
        assert header is not None
        service.send_response(SetBool.Response(message=str(request.data)), header)

    waits = added(node, Waits('service', service.handle, answer))
    client = node.create_client(SetBool, 'switch')
    with Spinner(executor, node):
        assert client.wait_for_service(PATIENCE)
        assert result_of(client.call_async(SetBool.Request(data=True))).message == 'True'
        waits.taken.expect(1, PATIENCE)


def test_the_response_to_a_client_wakes_it(make_node: MakeNode, executor: Executor, spin: Spin) -> None:
    node, server = make_node(), make_node('server')
    server.create_service(SetBool, 'switch', lambda _, response: response)
    spin(server)
    client = node.create_client(SetBool, 'switch')
    waits = added(node, Waits('client', client.handle))
    with Spinner(executor, node):
        assert client.wait_for_service(PATIENCE)
        answer = client.call_async(SetBool.Request())
        waits.taken.expect(1, PATIENCE)
        assert answer.done()


class Counted(Waits):
    """Waits for nothing but a number that the program sets."""

    def __init__(self) -> None:
        super().__init__('timer', None)
        self.left = 0

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        """Nothing to wait for."""

    def is_ready(self, wait_set: WaitSet) -> bool:
        return self.left > 0

    def take_data(self) -> object:
        self.left -= 1
        return self.left


def test_one_without_entities_is_asked_when_the_executor_is_woken(
    make_node: MakeNode, executor: Executor
) -> None:
    node, counted = make_node(), Counted()
    node.add_waitable(counted)

    def count_again() -> str:
        counted.left = 1
        return 'another callback'

    with Spinner(executor, node):
        counted.left = 3
        executor.wake()
        assert counted.taken.expect(3, PATIENCE) == [2, 1, 0]
        result_of(executor.create_task(count_again))
        counted.taken.expect(4, PATIENCE)


@pytest.mark.parametrize('by_guard', [True, False], ids=['trigger', 'wake'])
def test_what_happens_between_the_question_and_the_sleep_is_not_missed(
    make_node: MakeNode, executor: Executor, by_guard: bool
) -> None:
    node = make_node()
    guard = node.create_guard_condition(None)

    class Late(Counted):
        def add_to_wait_set(self, wait_set: WaitSet) -> None:
            if by_guard:
                wait_set.add_guard_condition(guard)

        def is_ready(self, wait_set: WaitSet) -> bool:
            ready = super().is_ready(wait_set)
            if not ready and not self.taken.items:  # it changes right behind the answer
                self.left = 1
                guard.trigger() if by_guard else executor.wake()
            return ready

    late = Late()
    node.add_waitable(late)
    with Spinner(executor, node):
        late.taken.expect(1, PATIENCE)


def test_who_comes_while_another_thread_asks_has_it_asked_again(make_node: MakeNode) -> None:
    asked, go_on = Collector[int](), threading.Event()

    class Slow(Counted):
        def is_ready(self, wait_set: WaitSet) -> bool:
            ready = super().is_ready(wait_set)
            asked(1)
            assert go_on.wait(PATIENCE)
            return ready

    slow = Slow()
    poller = WaitablePoller(make_node().handle.work_queue, slow)
    first = threading.Thread(target=poller.look)
    first.start()
    asked.expect(1)
    slow.left = 1
    poller.look()  # returns at once
    go_on.set()
    first.join(PATIENCE)
    assert len(asked.items) == 2


# -- how it runs ---------------------------------------------------------------------------------------------


def test_spin_once_runs_it_and_nothing_else(
    make_node: MakeNode, executor: Executor, context: Context
) -> None:
    node = make_node()
    guard = GuardCondition(None, None, context)
    waits = added(node, Waits('guard_condition', guard))
    executor.add_node(node)
    executor.spin_once(timeout_sec=0)
    assert waits.taken.items == []
    guard.trigger()
    executor.spin_once(timeout_sec=PATIENCE)
    assert waits.taken.expect(1, PATIENCE) == ['taken']


def test_executors_written_by_users_are_told_whose_callback_it_is(make_node: MakeNode) -> None:
    node = make_node()
    guard = node.create_guard_condition(None)
    waits = added(node, Waits('guard_condition', guard))
    subscription = node.create_subscription(String, 'words', print, 10)
    service = node.create_service(SetBool, 'switch', lambda _, response: response)
    client = node.create_client(SetBool, 'switch')
    publisher = node.create_publisher(String, 'words', 10)
    wait_until(node.context, lambda: publisher.get_subscription_count() == 1)
    assert client.wait_for_service(PATIENCE)
    with SingleThreadedExecutor(context=node.context) as executor:
        executor.add_node(node)
        for act, entity in (
            (guard.trigger, waits),
            (lambda: publisher.publish(String()), subscription),
            (lambda: client.call_async(SetBool.Request()), service),
        ):
            act()
            seen: list[object] = []
            while entity not in seen:
                handler, found, where = executor.wait_for_ready_callbacks(timeout_sec=PATIENCE)
                assert where is node
                seen.append(found)
                handler()


def test_it_moves_with_its_node(make_node: MakeNode, context: Context) -> None:
    node = make_node()
    guard = GuardCondition(None, None, context)
    waits = added(node, Waits('guard_condition', guard))
    with SingleThreadedExecutor(context=context) as first:
        with Spinner(first, node):
            guard.trigger()
            waits.taken.expect(1, PATIENCE)
        with Spinner(MultiThreadedExecutor(2, context=context), node):
            guard.trigger()
            waits.taken.expect(2, PATIENCE)


def test_an_executor_that_its_node_has_left_asks_it_no_more(make_node: MakeNode) -> None:
    node = make_node()
    waits = added(node, Waits('guard_condition', node.create_guard_condition(None)))
    with SingleThreadedExecutor(context=node.context) as executor:
        executor.add_node(node)
        executor.spin_once(timeout_sec=0)
        assert waits.index == 0
        executor.remove_node(node)
        waits.index = -1
        executor.spin_once(timeout_sec=0)
        assert waits.index == -1


def test_one_that_was_removed_runs_no_more(make_node: MakeNode, executor: Executor) -> None:
    node = make_node()
    guard = node.create_guard_condition(None)
    gone, stays = added(node, Waits('guard_condition', guard)), added(node, Waits('guard_condition', guard))
    assert list(node.waitables) == [gone, stays]
    node.remove_waitable(gone)
    with Spinner(executor, node):
        guard.trigger()
        stays.taken.expect(1, PATIENCE)
    assert gone.taken.items == []
    assert len(guard.watchers) == 1
    with pytest.raises(ValueError, match='not in list'):
        node.remove_waitable(gone)


def test_a_destroyed_node_asks_its_waitables_no_more(make_node: MakeNode) -> None:
    node = make_node()
    guard = GuardCondition(None, None, node.context)
    added(node, Waits('guard_condition', guard))
    with SingleThreadedExecutor(context=node.context) as executor:
        executor.add_node(node)
        executor.spin_once(timeout_sec=0)
        assert len(guard.watchers) == 1
        node.destroy_node()
    assert list(node.waitables) == []
    assert len(guard.watchers) == 0


def test_it_keeps_the_rule_of_its_group(make_node: MakeNode, context: Context) -> None:
    group = MutuallyExclusiveCallbackGroup()
    node = make_node()
    guard, begun, free = node.create_guard_condition(None), threading.Event(), threading.Event()
    waits = added(node, Waits('guard_condition', guard, group=group))

    def block() -> None:
        begun.set()
        assert free.wait(PATIENCE)

    node.create_guard_condition(block, group).trigger()
    with Spinner(MultiThreadedExecutor(4, context=context), node) as spinner:
        assert begun.wait(PATIENCE)
        guard.trigger()
        result_of(spinner.executor.create_task(lambda: 'another turn'))
        result_of(spinner.executor.create_task(lambda: 'and another one'))
        assert waits.taken.items == []
        assert not waits.ready, 'asked while its group was busy'
        free.set()
        waits.taken.expect(1, PATIENCE)


def test_it_awaits_futures_and_asyncio(make_node: MakeNode, executor: Executor, spin: Spin) -> None:
    node, server = make_node(), make_node('server')
    server.create_service(SetBool, 'switch', lambda _, response: response)
    spin(server)
    client = node.create_client(SetBool, 'switch')
    answers: Collector[object] = Collector()

    class Asks(Waits):
        async def execute(self, taken_data: object) -> None:
            import asyncio

            await asyncio.sleep(0)
            answers(await client.call_async(SetBool.Request()))

    guard = node.create_guard_condition(None)
    added(node, Asks('guard_condition', guard, group=MutuallyExclusiveCallbackGroup()))
    assert client.wait_for_service(PATIENCE)
    with Spinner(executor, node):
        guard.trigger()
        assert answers.expect(1, PATIENCE) == [SetBool.Response()]


def test_its_futures_call_back_in_its_executor(make_node: MakeNode, executor: Executor) -> None:
    node, future = make_node(), Future[int]()
    guard, names = node.create_guard_condition(None), Collector[str]()
    waits = added(node, Waits('guard_condition', guard))
    waits.add_future(future)
    with Spinner(executor, node):
        guard.trigger()
        waits.taken.expect(1, PATIENCE)
        future.add_done_callback(lambda _: names(threading.current_thread().name))
        future.set_result(1)
        assert names.expect(1, PATIENCE) != [threading.current_thread().name]
    waits.remove_future(future)
    with pytest.raises(ValueError, match='not in list'):
        waits.remove_future(future)


@pytest.mark.parametrize('method', ['add_to_wait_set', 'is_ready', 'take_data', 'execute'])
def test_what_it_raises_comes_out_of_spin(
    make_node: MakeNode, executor: Executor, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    node = make_node()
    guard = node.create_guard_condition(None)

    def fail(*_: object) -> None:
        monkeypatch.undo()
        raise ZeroDivisionError(method)

    monkeypatch.setattr(Waits, method, fail)
    waits = added(node, Waits('guard_condition', guard))
    guard.trigger()
    with Spinner(executor, node) as spinner:
        assert str(spinner.expect_raised(ZeroDivisionError)) == method
        guard.trigger()
        waits.taken.expect(1, PATIENCE)  # and it goes on


def test_one_that_cannot_be_entered_any_more_is_left_alone(make_node: MakeNode, executor: Executor) -> None:
    class Gone(Waits):
        def __enter__(self) -> object:
            raise InvalidHandle

    node = make_node()
    guard = node.create_guard_condition(None)
    gone, stays = added(node, Gone('guard_condition', guard)), added(node, Waits('guard_condition', guard))
    with Spinner(executor, node):
        guard.trigger()
        stays.taken.expect(1, PATIENCE)
    assert gone.taken.items == []


def test_what_is_missing_is_named(make_node: MakeNode) -> None:
    class Half(Waitable[None]):
        pass

    node = make_node()
    node.add_waitable(Half(ReentrantCallbackGroup()))
    with SingleThreadedExecutor(context=node.context) as executor:
        executor.add_node(node)
        with pytest.raises(NotImplementedError, match=r'Half must have an add_to_wait_set\(wait_set\)'):
            executor.spin_once(timeout_sec=PATIENCE)


def test_many_triggers_from_many_threads_lose_none(make_node: MakeNode, executor: Executor) -> None:
    node = make_node()
    guards = [GuardCondition(None, None, node.context) for _ in range(4)]
    waiting = [added(node, Waits('guard_condition', guard)) for guard in guards]

    def storm(guard: GuardCondition, waits: Waits) -> None:
        for count in range(1, 26):
            guard.trigger()
            waits.taken.expect(count, PATIENCE)

    threads = [threading.Thread(target=storm, args=pair) for pair in zip(guards, waiting, strict=True)]
    with Spinner(executor, node):
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(PATIENCE)
    assert [len(waits.taken.items) for waits in waiting] == [25] * 4


def test_an_executor_keeps_no_node_alive_for_its_waitables(context: Context) -> None:
    node = Node('short', context=context)
    added(node, Waits('guard_condition', node.create_guard_condition(None)))
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(node)
        executor.spin_once(timeout_sec=0)
        work_queue = weakref.ref(node.handle.work_queue)
        executor.remove_node(node)
        node.handle.destroy()  # the context holds what is declared
        del node
        gc.collect()
        assert work_queue() is None
        executor.spin_once(timeout_sec=0)


def test_it_runs_in_an_asyncio_loop_too(isolated: dict[str, str], context: Context) -> None:
    class Sets(Waits):
        async def execute(self, taken_data: object) -> None:
            done.set()

    async def program() -> None:
        async with AsyncNode('node', context=context) as node, asyncio.timeout(PATIENCE):
            guard = GuardCondition(None, None, context)
            node.add_waitable(Sets('guard_condition', guard))
            threading.Thread(target=guard.trigger).start()
            await done.wait()

    done = asyncio.Event()
    asyncio.run(program())


# -- the wait set --------------------------------------------------------------------------------------------


def test_a_wait_set_refuses_what_was_not_added() -> None:
    wait_set = WaitSet(lambda: None)
    guard = GuardCondition(None, None)
    assert [wait_set.add_guard_condition(guard), wait_set.add_guard_condition(guard)] == [0, 1]
    guard.trigger()
    wait_set.look()
    assert wait_set.is_ready('guard_condition', 1)
    with pytest.raises(IndexError, match='no guard_condition was added under the index 2: there are 2'):
        wait_set.is_ready('guard_condition', 2)
    with pytest.raises(RuntimeError, match="'guard' is not a known entity"):
        wait_set.is_ready('guard', 0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r'add_timer\(\) takes the handle of a timer, got int'):
        wait_set.add_timer(5)


def test_numbers_of_entities_add_up() -> None:
    total = NumberOfEntities(1, 2, 3) + NumberOfEntities(num_subs=1, num_events=6)
    assert total == NumberOfEntities(2, 2, 3, 0, 0, 6)
    assert total.num_guard_conditions == 2
    assert total != NumberOfEntities()


# -- action clients and servers, by hand ---------------------------------------------------------------------


def by_hand(waitable: Waitable[Any]) -> None:
    """Wait until it is ready and run one of its callbacks on this thread."""
    woken = threading.Event()
    wait_set = WaitSet(woken.set)
    waitable.add_to_wait_set(wait_set)
    wait_set.look()
    if not waitable.is_ready(wait_set):
        assert woken.wait(PATIENCE)
    assert waitable.is_ready(wait_set)
    asyncio.run(waitable.execute(waitable.take_data()))
    wait_set.close()


def test_actions_can_be_worked_by_hand(make_node: MakeNode) -> None:
    node = make_node()
    client = ActionClient(node, Fibonacci, 'fib')
    server = ActionServer(node, Fibonacci, 'fib', succeed)
    assert list(node.waitables) == [client, server]
    assert server.get_num_entities() == NumberOfEntities(num_timers=1, num_services=3)
    assert client.get_num_entities() == NumberOfEntities(num_subs=2, num_clients=3)
    assert client.wait_for_server(PATIENCE)
    heard: Collector[Any] = Collector()
    sent = client.send_goal_async(Fibonacci.Goal(order=3), heard)
    by_hand(server)
    assert result_of(sent).accepted
    assert server.take_data() is None
    asyncio.run(server.execute(None))


def test_feedback_can_be_taken_by_hand(make_node: MakeNode, spin: Spin) -> None:
    def tell(handle: ServerGoalHandle) -> Fibonacci.Result:
        handle.publish_feedback(Fibonacci.Feedback(sequence=[7]))
        return succeed(handle)

    node, other = make_node(), make_node('server')
    client = ActionClient(node, Fibonacci, 'fib')
    ActionServer(other, Fibonacci, 'fib', tell)
    spin(other)
    assert client.wait_for_server(PATIENCE)
    heard: Collector[Any] = Collector()
    handle = result_of(client.send_goal_async(Fibonacci.Goal(), heard))
    result_of(handle.get_result_async())
    while not heard.items:
        by_hand(client)
    assert list(heard.items[0].feedback.sequence) == [7]
