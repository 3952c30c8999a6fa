"""An updater on a node: when it publishes, under which names, and what programs do wrong."""

from __future__ import annotations

from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from diagnostic_updater import (
    DiagnosedPublisher,
    DiagnosticStatusWrapper,
    FrequencyStatusParam,
    Heartbeat,
    TimeStampStatusParam,
    Updater,
)
from helpers.collector import Collector
from helpers.patience import wait_for
from helpers.spinning import MakeNode, Spin
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image
from std_msgs.msg import Header

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
NEVER = 3600.0  # a period that no test sees


@pytest.fixture
def published(make_node: MakeNode, spin: Spin) -> Collector[DiagnosticArray]:
    """All that is said on /diagnostics, from before the first updater on."""
    came = Collector[DiagnosticArray]()
    listener = make_node('listener')
    listener.create_subscription(DiagnosticArray, '/diagnostics', came, 100)
    spin(listener)
    return came


def make_updater(node: Node, period: float = NEVER) -> Updater:
    updater = Updater(node, period)
    updater.setHardwareID('T-1')
    return updater


def find_warm(stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
    stat.summary(WARN, 'warm')
    stat.add('temperature', 61)
    return stat


def test_a_task_is_announced_and_then_published_with_each_update(
    make_node: MakeNode, published: Collector[DiagnosticArray]
) -> None:
    updater = make_updater(make_node('arm'))
    updater.add('motor', find_warm)
    updater.add(Heartbeat())
    updater.update()
    first, second, update = published.expect(3)
    assert [(status.name, status.message) for status in first.status] == [('arm: motor', 'Node starting up')]
    assert [status.name for status in second.status] == ['arm: Heartbeat']
    motor, heartbeat = update.status
    assert (motor.name, motor.level, motor.message, motor.hardware_id) == ('arm: motor', WARN, 'warm', 'T-1')
    assert [(value.key, value.value) for value in motor.values] == [('temperature', '61')]
    assert (heartbeat.name, heartbeat.level, heartbeat.message) == ('arm: Heartbeat', OK, 'Alive')
    assert update.header.stamp.sec > 0


def test_the_timer_updates_again_and_again(
    make_node: MakeNode, spin: Spin, published: Collector[DiagnosticArray]
) -> None:
    node = make_node('arm')
    make_updater(node, 0.01).add(Heartbeat())
    spin(node)
    assert [array.status[0].message for array in published.expect(4)[1:4]] == ['Alive'] * 3


def test_a_new_period_replaces_the_timer(
    make_node: MakeNode, spin: Spin, published: Collector[DiagnosticArray]
) -> None:
    node = make_node('arm')
    updater = make_updater(node)
    updater.add(Heartbeat())
    updater.period = 0.01
    assert len(list(node.timers)) == 1
    spin(node)
    assert published.expect(2)[1].status[0].message == 'Alive'


@pytest.mark.parametrize(
    ('use_fqn', 'namespace', 'name'),
    [(False, '/left', 'arm: x'), (True, '/left', '/left/arm: x'), (True, '/', '/arm: x')],
)
@pytest.mark.parametrize('declared', [True, False])
def test_parameters_choose_name_and_period(
    use_fqn: bool,
    namespace: str,
    name: str,
    declared: bool,
    make_node: MakeNode,
    published: Collector[DiagnosticArray],
) -> None:
    overrides = [
        Parameter('diagnostic_updater.use_fqn', value=use_fqn),
        Parameter('diagnostic_updater.period', value=7.0),
    ]
    node = make_node(
        'arm',
        namespace=namespace,
        parameter_overrides=overrides,
        automatically_declare_parameters_from_overrides=declared,
    )
    updater = make_updater(node)
    updater.add('x', find_warm)
    assert published.expect()[0].status[0].name == name
    assert (updater.period, updater.timer.timer_period_ns) == (7.0, 7_000_000_000)


def test_a_broadcast_says_the_same_for_every_task_and_runs_none(
    make_node: MakeNode, published: Collector[DiagnosticArray]
) -> None:
    updater, ran = make_updater(make_node('arm')), list[Any]()
    updater.add('a', ran.append)  # type: ignore[arg-type]  # never called
    updater.add('b', ran.append)  # type: ignore[arg-type]
    updater.broadcast(ERROR, 'going down')
    statuses = published.expect(3)[2].status
    assert [(status.name, status.level, status.message) for status in statuses] == [
        ('arm: a', ERROR, 'going down'),
        ('arm: b', ERROR, 'going down'),
    ]
    assert ran == []


def test_a_removed_task_runs_no_more(make_node: MakeNode, published: Collector[DiagnosticArray]) -> None:
    updater = make_updater(make_node('arm'))
    updater.add('motor', find_warm)
    updater.add(Heartbeat())
    assert updater.removeByName('motor')
    assert not updater.removeByName('motor')
    updater.force_update()
    assert [status.name for status in published.expect(3)[2].status] == ['arm: Heartbeat']


def test_a_task_may_change_the_list_that_it_is_in(
    make_node: MakeNode, published: Collector[DiagnosticArray]
) -> None:
    updater = make_updater(make_node('arm'))

    def remove_itself(stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        updater.removeByName('once')
        return find_warm(stat)

    updater.add('once', remove_itself)
    updater.update()
    updater.update()
    assert [len(array.status) for array in published.expect(3)] == [1, 1, 0]


def test_a_diagnosed_publisher_publishes_and_is_watched(
    make_node: MakeNode, published: Collector[DiagnosticArray]
) -> None:
    node = make_node('camera')
    updater = make_updater(node)
    camera = DiagnosedPublisher(
        node.create_publisher(Image, 'image', 1),
        updater,
        FrequencyStatusParam({'min': 0.0}),
        TimeStampStatusParam(),
    )
    camera.publish(Image(header=Header(stamp=node.get_clock().now().to_msg())))
    updater.update()
    (status,) = published.expect(2)[1].status
    assert (status.name, status.level) == ('camera: /image topic status', OK)
    assert status.message == 'Desired frequency met; Timestamps are reasonable.'
    camera.clear_window()
    updater.update()
    (status,) = published.expect(3)[2].status
    assert (status.level, status.message) == (ERROR, 'No events recorded.; No data since last update.')


def test_stamps_of_simulated_time_are_judged_by_the_node_s_clock(
    make_node: MakeNode, published: Collector[DiagnosticArray], spin: Spin
) -> None:
    """By the system's time, pictures of a simulation that began a minute ago would be decades old."""
    node = make_node('eye', parameter_overrides=[Parameter('use_sim_time', value=True)])
    simulation = make_node('simulation').create_publisher(Clock, '/clock', 1)
    spin(node)
    wait_for(simulation.get_subscription_count, 'the subscription to /clock')
    simulation.publish(Clock(clock=Time(seconds=60).to_msg()))
    wait_for(lambda: node.get_clock().now().nanoseconds, 'the simulated time')
    updater = make_updater(node)
    frequency, stamps = FrequencyStatusParam({'min': 0, 'max': 1e9}), TimeStampStatusParam(-1, 5)
    camera = DiagnosedPublisher(node.create_publisher(Image, 'image', 10), updater, frequency, stamps)
    camera.publish(Image(header=Header(stamp=node.get_clock().now().to_msg())))
    updater.update()
    *_, update = published.expect(2)
    (status,) = update.status
    assert (status.level, status.message) == (OK, 'Desired frequency met; Timestamps are reasonable.')


def test_two_updaters_share_a_node_and_its_parameters(make_node: MakeNode) -> None:
    node = make_node('arm')
    assert make_updater(node, 5.0).period == make_updater(node, 9.0).period == 5.0


@pytest.mark.parametrize('args', [('motor',), (find_warm,), ('motor', 5), ('motor', find_warm, 1)])
def test_add_refuses_other_things(args: tuple[object, ...], make_node: MakeNode) -> None:
    updater = make_updater(make_node('arm'))
    with pytest.raises(TypeError, match='a name and a function'):
        updater.add(*args)  # type: ignore[call-overload]
    assert updater.tasks == []


def test_a_task_need_not_derive_from_diagnostic_task(
    make_node: MakeNode, published: Collector[DiagnosticArray]
) -> None:
    class Pump:
        def getName(self) -> str:
            return 'pump'

        def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
            return find_warm(stat)

    updater = make_updater(make_node('arm'))
    updater.add(Pump())
    updater.update()
    assert [(status.name, status.message) for status in published.expect(2)[1].status] == [
        ('arm: pump', 'warm')
    ]


def test_an_integer_period_takes_an_integer_of_a_parameter_file(make_node: MakeNode) -> None:
    node = make_node('arm', parameter_overrides=[Parameter('diagnostic_updater.period', value=7)])
    assert make_updater(node, 2).period == 7


def test_a_task_without_return_is_named(make_node: MakeNode) -> None:
    updater = make_updater(make_node('arm'))
    updater.add('motor', lambda stat: stat.summary(OK, 'fine'))  # type: ignore[arg-type, return-value]
    with pytest.raises(TypeError, match="'motor' returned None, not a status"):
        updater.update()


def test_what_is_wrong_is_logged_if_it_is_verbose(
    make_node: MakeNode, capfd: pytest.CaptureFixture[str]
) -> None:
    updater = make_updater(make_node('arm'))
    updater.add('motor', find_warm)
    updater.update()
    assert capfd.readouterr().err == ''
    updater.verbose = True
    updater.update()
    assert 'Non-zero diagnostic status. Name: motor, status 1: warm' in capfd.readouterr().err


def test_a_missing_hardware_id_is_warned_of_once_all_is_well(
    make_node: MakeNode, capfd: pytest.CaptureFixture[str]
) -> None:
    updater = Updater(make_node('arm'), NEVER)
    updater.add('motor', find_warm)
    updater.update()
    assert 'HW_ID' not in capfd.readouterr().err
    updater.removeByName('motor')
    for _ in range(2):
        updater.update()
    assert capfd.readouterr().err.count('No HW_ID was set. Call setHardwareID') == 1
