"""Our RTPS session beside other implementations: topics both ways, of all sizes, and what was said before."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TypeAlias

import pytest
from helpers import real_rclpy
from helpers.environments import Environment
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.rtps_network import Collector
from helpers.rtps_sides import Side, decode_string, encode_string
from helpers.wires import DDS, require

from goalwire.rtps.io.addresses import Reach
from goalwire.rtps.protocol.qos import BEST_EFFORT, RELIABLE, TRANSIENT_LOCAL, Qos

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

Install: TypeAlias = Callable[..., Environment]

ECHO = Path(__file__).parent / 'programs' / 'rtps_rclpy_echo.py'
LATCHED = Qos(reliability=RELIABLE, durability=TRANSIENT_LOCAL)
LEAVING_S = 8.0
"""Seconds in which a program leaves that says so. Leases are longer: 10 s, and 20 s."""
SIZES = (1, 1000, 100_000, 1_000_000)


@pytest.fixture(params=['Cyclone DDS', 'Fast DDS'])
def start(
    request: pytest.FixtureRequest, install: Install
) -> Iterator[Callable[[str, str], tuple[Program, Side]]]:
    """A function that starts rclpy on another implementation, and a session of ours beside it."""
    if request.param == 'Fast DDS':
        if not real_rclpy.EXISTS:
            pytest.skip(real_rclpy.WHY_NOT)
        python, rmw = install(*real_rclpy.WHEELS).python, 'rmw_fastrtps_cpp'
    else:
        require(DDS)
        python, rmw = Path(sys.executable), 'rmw_cyclonedds_cpp'
    with ExitStack() as stack:

        def start_both(reliability: str, reach: str = 'LOCALHOST') -> tuple[Program, Side]:
            env = isolated_env(rmw) | {'ROS_AUTOMATIC_DISCOVERY_RANGE': reach}
            echo = stack.enter_context(Program(ECHO, reliability, env=env, python=python))
            echo.expect('ready')
            return echo, stack.enter_context(Side(int(env['ROS_DOMAIN_ID']), Reach[reach]))

        yield start_both


def _echo(side: Side, qos: Qos, texts: list[str]) -> list[str]:
    """Send texts one after the other, and return what came back; the first is sent until it does."""
    writer, publisher = side.writer('rt/ping', qos)
    _, collector = side.reader('rt/pong', qos)
    side.wait_for(lambda: publisher.matched and collector.matched, 'a match')

    def greeted() -> bool:
        writer.write(encode_string('hello'))
        return bool(collector.samples)

    side.wait_for(greeted, 'a first answer')
    for text in texts:
        writer.write(encode_string(text))
        side.wait_for(partial(_is_last, collector, text), 'an answer')
    return [text for payload in collector.payloads if (text := decode_string(payload)) != 'hello']


def _is_last(collector: Collector, text: str) -> bool:
    return decode_string(collector.payloads[-1]) == text


def test_reliable_topics_go_both_ways(start: Callable[..., tuple[Program, Side]]) -> None:
    _, side = start('RELIABLE')
    texts = [f'{number}' + 'x' * size for size in SIZES for number in range(5)]
    assert _echo(side, Qos(reliability=RELIABLE, depth=10), texts) == texts


def test_best_effort_topics_go_both_ways(start: Callable[..., tuple[Program, Side]]) -> None:
    _, side = start('BEST_EFFORT')
    texts = [f'{number}' + 'x' * size for size in SIZES[:3] for number in range(3)]
    assert _echo(side, Qos(reliability=BEST_EFFORT, depth=10), texts) == texts


def test_who_comes_later_gets_what_was_said_before(start: Callable[..., tuple[Program, Side]]) -> None:
    echo, side = start('RELIABLE')
    writer, _ = side.writer('rt/latched_ping', LATCHED)
    writer.write(encode_string('ours'))
    _, collector = side.reader('rt/latched', LATCHED)
    side.wait_for(lambda: collector.samples, 'what was latched')
    assert [decode_string(payload) for payload in collector.payloads] == ['said before']
    assert echo.expect('latched: (.*)')[1] == 'ours'


def test_who_comes_and_goes_is_noticed(start: Callable[..., tuple[Program, Side]]) -> None:
    echo, side = start('RELIABLE')
    side.wait_for(lambda: any(each.topic == 'rt/ping' for each in side.watcher.endpoints.values()))
    (participant,) = side.watcher.participants.values()
    assert participant.user_data == b'enclave=/;'
    echo.send_signal(signal.SIGINT)
    side.wait_for(lambda: not side.watcher.participants, 'its end', LEAVING_S)
    assert not side.watcher.endpoints
    assert not side.session.rejects.counts()


def test_a_subnet_is_searched_by_multicast(start: Callable[..., tuple[Program, Side]]) -> None:
    _, side = start('RELIABLE', 'SUBNET')
    assert _echo(side, Qos(reliability=RELIABLE, depth=10), ['a', 'b']) == ['a', 'b']
