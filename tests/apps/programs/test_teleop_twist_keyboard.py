"""teleop_twist_keyboard: keys become velocities, and its end is a stop."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from helpers.collector import Collector
from helpers.isolation import NETWORK
from helpers.screens import Screen, screen
from helpers.spinning import Spinner
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

RUN = ('run', 'teleop_twist_keyboard', 'teleop_twist_keyboard')


@pytest.fixture
def transport_name() -> str:
    return NETWORK


@pytest.fixture
def node(isolated: dict[str, str]) -> Iterator[Node]:
    with rclpy.init():
        node = Node('base')
        with Spinner(SingleThreadedExecutor(), node):
            yield node


def _press_until_heard(terminal: Screen, key: bytes, heard: Collector[Any]) -> None:
    """Keys that are pressed before publisher and subscription have met are heard by nobody."""
    for _ in range(60):
        terminal.press(key)
        try:
            heard.expect(1, 0.5)
        except AssertionError:
            continue
        return
    raise AssertionError('no command came')


@pytest.mark.parametrize(
    'ending', [b'\x03', signal.SIGTERM, signal.SIGHUP], ids=['ctrl-c', 'SIGTERM', 'SIGHUP']
)
def test_its_end_is_a_stop(node: Node, isolated: dict[str, str], ending: bytes | signal.Signals) -> None:
    heard: Collector[Twist] = Collector()
    node.create_subscription(Twist, 'cmd_vel', heard, 10)
    with screen(isolated, *RUN) as terminal:
        terminal.expect('currently')
        _press_until_heard(terminal, b'i', heard)
        assert heard.items[0].linear.x == 0.5
        if isinstance(ending, bytes):
            terminal.press(ending)
        else:
            terminal.process.send_signal(ending)
        assert terminal.wait() == 0
        heard.wait_for(lambda items: items[-1] == Twist())


@pytest.mark.parametrize('key', [b'\x1b', b'\x1b[A', b' '], ids=['escape', 'arrow', 'space'])
def test_a_key_without_a_meaning_is_a_stop(node: Node, isolated: dict[str, str], key: bytes) -> None:
    heard: Collector[Twist] = Collector()
    node.create_subscription(Twist, 'cmd_vel', heard, 10)
    with screen(isolated, *RUN) as terminal:
        terminal.expect('currently')
        _press_until_heard(terminal, b'i', heard)
        terminal.press(key)
        heard.wait_for(lambda items: items[-1] == Twist())


def test_speeds_grow_and_stamps_are_given(node: Node, isolated: dict[str, str]) -> None:
    heard: Collector[TwistStamped] = Collector()
    node.create_subscription(TwistStamped, 'cmd_vel', heard, 10)
    arguments = ('--ros-args', '-p', 'stamped:=true', '-p', 'frame_id:=base', '-p', 'turn:=2.0')
    with screen(isolated, *RUN, *arguments) as terminal:
        terminal.expect('currently')  # keys that are pressed before are not read
        terminal.press(b'q')
        terminal.expect(r'speed 0\.55\S*\s+turn 2\.2')
        _press_until_heard(terminal, b'j', heard)
        message = heard.items[0]
        assert message.header.frame_id == 'base'
        assert message.header.stamp.sec > 0
        assert message.twist.angular.z == pytest.approx(2.2)


def test_a_speed_that_is_not_above_zero_is_not_taken(isolated: dict[str, str]) -> None:
    with screen(isolated, *RUN, '--ros-args', '-p', 'speed:=-1.0') as terminal:
        terminal.expect('The parameter speed is -1.0: it must be above 0; 0.5 is used')
