"""Simulated time: `use_sim_time`, /clock, and all that goes by a node's clock."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest
from builtin_interfaces.msg import Time as Stamp
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, wait_until
from rcl_interfaces.msg import SetParametersResult
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock, JumpThreshold, ROSClock, TimeJump
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import ReliabilityPolicy
from rclpy.time import Time
from rclpy.time_source import CLOCK_TOPIC, USE_SIM_TIME_NAME, TimeSource
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import Header

SIMULATED = Parameter('use_sim_time', value=True)
REAL = Parameter('use_sim_time', value=False)
ANY_JUMP_BACK = JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1))


def ros(seconds: float) -> Time:
    return Time(seconds=seconds, clock_type=ClockType.ROS_TIME)


def is_simulated(node: Node) -> bool:
    """Whether the node's clock says so."""
    clock = node.get_clock()
    assert isinstance(clock, ROSClock)
    return clock.ros_time_is_active


class Simulator:
    """Publishes /clock."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(ClockMessage, '/clock', 10)

    def await_listeners(self, count: int) -> None:
        """Wait until so many nodes listen."""
        wait_until(self._node.context, lambda: self._publisher.get_subscription_count() == count)

    def set(self, seconds: float, *clocks: Clock) -> None:
        """Publish a time and wait until `clocks`, now before it, show it."""
        self._publisher.publish(ClockMessage(clock=ros(seconds).to_msg()))
        for clock in clocks:
            assert clock.sleep_until(ros(seconds), self._node.context)

    def say(self, payload: bytes) -> None:
        """Publish something that need not be a time."""
        self._publisher.publish(payload)


@pytest.fixture
def simulator(make_node: MakeNode) -> Simulator:
    return Simulator(make_node('simulator'))


@pytest.fixture
def simulated(make_node: MakeNode, simulator: Simulator) -> Node:
    """A node that lives in simulated time, at second 0."""
    node = make_node('simulated', parameter_overrides=[SIMULATED])
    simulator.await_listeners(1)
    return node


def test_each_node_has_the_parameter_and_begins_in_real_time(make_node: MakeNode) -> None:
    node = make_node()
    assert node.get_parameter(USE_SIM_TIME_NAME).value is False
    clock = node.get_clock()
    assert repr(clock) == 'Clock(clock_type=ROS_TIME)'
    assert not is_simulated(node)
    assert clock.now().nanoseconds > 10**18


def test_the_parameter_switches_the_clock_at_run_time(make_node: MakeNode) -> None:
    node = make_node()
    for _ in range(2):
        assert node.set_parameters([SIMULATED]) == [SetParametersResult(successful=True)]
        assert is_simulated(node)
        assert repr(node.get_clock().now()) == 'Time(nanoseconds=0, clock_type=ROS_TIME)'
        assert [entity.topic_name for entity in node.subscriptions] == [CLOCK_TOPIC]
        assert node.set_parameters([REAL]) == [SetParametersResult(successful=True)]
        assert not is_simulated(node)
        assert list(node.subscriptions) == []
        assert node.get_clock().now().nanoseconds > 10**18


def test_a_value_of_another_type_is_refused(make_node: MakeNode) -> None:
    node = make_node()
    [result] = node.set_parameters([Parameter('use_sim_time', value=1)])
    assert result.reason == "Wrong parameter type, expected 'Type.BOOL' got 'Type.INTEGER'"
    assert not is_simulated(node)


def test_an_override_of_another_type_is_refused_and_leaves_no_node(make_node: MakeNode) -> None:
    observer = make_node('observer')
    with pytest.raises(InvalidParameterTypeException, match='use_sim_time'):
        make_node('wrong', parameter_overrides=[Parameter('use_sim_time', value='yes')])
    wait_until(observer.context, lambda: observer.get_node_names() == ['observer'])


def test_a_set_that_another_callback_refuses_does_not_switch(make_node: MakeNode) -> None:
    node = make_node()
    node.add_on_set_parameters_callback(lambda _: SetParametersResult(successful=False, reason='no'))
    assert not node.set_parameters([SIMULATED])[0].successful
    assert not is_simulated(node)


def test_the_command_line_switches_it(make_node: MakeNode) -> None:
    node = make_node(cli_args=['--ros-args', '-p', 'use_sim_time:=true'])
    assert is_simulated(node)


def test_the_clock_follows_the_topic_whoever_spins(simulated: Node, simulator: Simulator) -> None:
    clock = simulated.get_clock()
    for seconds in (5, 5.5, 7):
        simulator.set(seconds, clock)
        assert clock.now() == ros(seconds)
    header = Header()
    header.stamp = clock.now().to_msg()
    assert header.stamp == Stamp(sec=7)


def test_clock_is_listened_to_as_ros_2_does_and_only_while_needed(
    simulated: Node, simulator: Simulator
) -> None:
    [info] = simulated.get_subscriptions_info_by_topic('/clock')
    assert info.qos_profile.reliability is ReliabilityPolicy.BEST_EFFORT
    assert info.qos_profile.depth == 1
    assert info.topic_type == 'rosgraph_msgs/msg/Clock'
    simulated.set_parameters([REAL])
    simulator.await_listeners(0)
    simulated.set_parameters([SIMULATED])
    simulator.await_listeners(1)
    simulated.destroy_node()
    simulator.await_listeners(0)


def test_what_is_no_clock_message_changes_nothing(simulated: Node, simulator: Simulator, spin: Spin) -> None:
    spin(simulated)
    clock = simulated.get_clock()
    simulator.set(5, clock)
    simulator.say(b'\x00\x01\x00\x00\x07')
    simulator.say(b'\x00\x01\x00\x00' + (-3).to_bytes(4, 'little', signed=True) + bytes(4))
    simulator.set(6, clock)
    [subscription] = simulated.subscriptions
    assert subscription.rejected == 2
    assert clock.now() == ros(6)


def test_a_timer_follows_the_topic(simulated: Node, simulator: Simulator, spin: Spin) -> None:
    clock, ticks = simulated.get_clock(), Collector[Time]()
    simulated.create_timer(1.0, lambda: ticks(clock.now()))
    spin(simulated)
    for count, seconds in enumerate((1, 3, 4), 1):
        simulator.set(seconds, clock)
        ticks.expect(count)
    simulator.set(4.9, clock)
    assert ticks.items == [ros(1), ros(3), ros(4)]


@pytest.mark.parametrize('threads', [1, 2])
def test_a_callback_may_sleep_until_a_simulated_time(
    simulated: Node, simulator: Simulator, spin: Spin, threads: int
) -> None:
    clock, sleeping, slept = simulated.get_clock(), threading.Event(), Collector[tuple[bool, Time]]()

    def sleep() -> None:
        once.cancel()
        sleeping.set()
        slept((clock.sleep_for(Duration(seconds=2), simulated.context), clock.now()))

    once = simulated.create_timer(0.0, sleep)
    spin(simulated, threads=threads)
    assert sleeping.wait(PATIENCE)
    simulator.set(1, clock)
    assert slept.items == []
    simulator.set(9, clock)
    assert slept.expect() == [(True, ros(9))]


def test_a_rate_in_a_callback_ticks_in_simulated_time(
    simulated: Node, simulator: Simulator, spin: Spin
) -> None:
    clock, ticks = simulated.get_clock(), Collector[Time]()
    rate = simulated.create_rate(1.0)

    def work() -> None:
        once.cancel()
        for _ in range(2):
            rate.sleep()
            ticks(clock.now())

    once = simulated.create_timer(0.0, work)
    spin(simulated)
    simulator.set(1, clock)
    ticks.expect(1)
    simulator.set(2, clock)
    assert ticks.expect(2) == [ros(1), ros(2)]


def test_callbacks_may_sleep_while_the_time_is_made_in_the_same_executor(
    make_node: MakeNode, simulated: Node, spin: Spin
) -> None:
    world, slept = make_node('world'), Collector[bool]()
    publisher = world.create_publisher(ClockMessage, '/clock', 10)
    clock, second = simulated.get_clock(), iter(range(1, 10**6))
    steady = Clock(clock_type=ClockType.STEADY_TIME)

    def sleep() -> None:
        slept(clock.sleep_until(ros(20), simulated.context))

    groups = [MutuallyExclusiveCallbackGroup() for _ in range(2)]
    for group in groups:
        simulated.create_guard_condition(sleep, group).trigger()
    world.create_timer(
        0.001, lambda: publisher.publish(ClockMessage(clock=Stamp(sec=next(second)))), clock=steady
    )
    spin(simulated, world, threads=2)
    assert slept.expect(2) == [True, True]


# -- jumps


class Jumps:
    """Notes every jump back of a clock, and on which thread it is told."""

    def __init__(self, clock: Clock) -> None:
        self.seen: Collector[tuple[float, Time]] = Collector()
        self._clock = clock
        clock.create_jump_callback(ANY_JUMP_BACK, post_callback=self._note)

    def _note(self, jump: TimeJump) -> None:
        self.seen((jump.delta.nanoseconds / 1e9, self._clock.now()))


def test_jump_callbacks_run_on_the_executor(simulated: Node, simulator: Simulator, spin: Spin) -> None:
    clock = simulated.get_clock()
    work: Collector[str] = Collector()
    simulated.create_guard_condition(lambda: work('done')).trigger()
    simulator.set(10, clock)
    jumps = Jumps(clock)
    spin(simulated)
    simulator.set(4)
    assert jumps.seen.expect() == [(-6.0, ros(4))]
    work.expect()
    assert jumps.seen.threads == work.threads


def test_a_jump_that_is_to_be_told_waits_for_the_executor(
    make_node: MakeNode, simulated: Node, simulator: Simulator, spin: Spin
) -> None:
    witness = make_node('witness', parameter_overrides=[SIMULATED])
    simulator.await_listeners(2)
    clock = simulated.get_clock()
    simulator.set(10, clock, witness.get_clock())
    jumps = Jumps(clock)
    for seconds in (4, 11):
        simulator.set(seconds)
    for seconds in (20, 21):  # when the witness has heard the second one, all have heard the first one
        simulator.set(seconds, witness.get_clock())
    assert clock.now() == ros(10)
    spin(simulated)
    assert clock.sleep_until(ros(21), simulated.context)
    assert jumps.seen.items == []
    simulator.set(2)
    assert jumps.seen.expect() == [(-19.0, ros(2))]
    simulator.set(3, clock)


@pytest.mark.parametrize('spun', [True, False], ids=['in a callback', 'in a node that nobody spins'])
def test_who_sleeps_where_jumps_are_told_is_told_himself(
    simulated: Node, simulator: Simulator, spin: Spin, spun: bool
) -> None:
    clock, sleeping, slept = simulated.get_clock(), threading.Event(), Collector[Time]()
    simulator.set(10, clock)
    jumps = Jumps(clock)

    def sleep() -> None:
        once.cancel()
        sleeping.set()
        clock.sleep_until(ros(12), simulated.context)
        slept(clock.now())

    once = simulated.create_timer(0.0, sleep)
    thread = threading.Thread(target=sleep)
    if spun:
        spin(simulated)
    else:
        thread.start()
    assert sleeping.wait(PATIENCE)
    simulator.set(4)
    assert jumps.seen.expect() == [(-6.0, ros(4))]
    simulator.set(11)
    simulator.set(12)
    assert slept.expect() == [ros(12)]
    assert jumps.seen.threads == slept.threads
    if not spun:
        thread.join()


def test_switching_calls_jump_callbacks_that_asked_for_it(make_node: MakeNode) -> None:
    node, changes = make_node(), list[str]()
    node.get_clock().create_jump_callback(
        ANY_JUMP_BACK, post_callback=lambda jump: changes.append(jump.clock_change.name)
    )
    node.set_parameters([SIMULATED])
    node.set_parameters([REAL])
    assert changes == ['ROS_TIME_ACTIVATED', 'ROS_TIME_DEACTIVATED']


# -- TimeSource by itself


def test_a_clock_attached_later_begins_with_the_last_time(make_node: MakeNode) -> None:
    source = TimeSource(node=make_node(parameter_overrides=[SIMULATED]))
    early, late = ROSClock(), ROSClock()
    source.attach_clock(early)
    source.clock_callback(ClockMessage(clock=Stamp(sec=8)))
    source.attach_clock(late)
    assert early.now() == late.now() == ros(8)
    source.ros_time_is_active = False
    assert (early.ros_time_is_active, late.ros_time_is_active) == (False, False)


def test_a_time_source_leaves_one_node_for_another(make_node: MakeNode) -> None:
    first, second = make_node('first'), make_node('second', parameter_overrides=[SIMULATED])
    source, states = TimeSource(), list[bool]()

    def note() -> None:
        states.append(source.ros_time_is_active)

    source.attach_node(first)
    note()
    source.attach_node(second)
    note()
    first.set_parameters([SIMULATED])
    first.set_parameters([REAL])
    note()
    assert states == [False, True, True]
    assert len(list(second.subscriptions)) == 2, "the node's own, and this one's"
    source.detach_node()
    source.detach_node()
    assert len(list(second.subscriptions)) == 1
    second.set_parameters([REAL])
    assert source.ros_time_is_active, 'it follows nobody'


@pytest.mark.parametrize(
    ('attach', 'error', 'message'),
    [
        (TimeSource.attach_node, TypeError, 'Node must be of type rclpy.node.Node'),
        (TimeSource.attach_clock, ValueError, 'Only clocks with type ROS_TIME can be attached.'),
    ],
)
def test_what_cannot_be_attached_is_refused(
    attach: Callable[[TimeSource, Any], None], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        attach(TimeSource(), Clock(clock_type=ClockType.STEADY_TIME))


def test_the_subscription_of_the_clock_is_listed_and_can_be_destroyed(
    make_node: MakeNode, simulated: Node
) -> None:
    (listed,) = [each for each in simulated.subscriptions if each.topic_name == CLOCK_TOPIC]
    assert simulated.destroy_subscription(listed)
    assert not simulated.destroy_subscription(listed)
    assert listed not in simulated.subscriptions
    assert make_node('other').destroy_subscription(listed) is False
