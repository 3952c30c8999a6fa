"""Several processes on DDS: large messages, a reader that is stopped, a peer that is killed."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import pytest
from helpers.collector import Collector
from helpers.isolation import lease_variables
from helpers.patience import PATIENCE
from helpers.processes import Program
from helpers.wire import Side

from goalwire.rules.qos import HistoryPolicy, QoS
from goalwire.transport.contract import EndpointKind, Sample, SessionOptions
from goalwire.transport.dds import TRANSPORT

KEEP_ALL = QoS(history=HistoryPolicy.KEEP_ALL)

ECHO = """
    import os, sys
    from helpers.wire import Side
    from goalwire.rules.qos import HistoryPolicy, QoS
    from goalwire.transport.contract import SessionOptions
    from goalwire.transport.dds import TRANSPORT

    session = TRANSPORT.open(SessionOptions(int(os.environ['ROS_DOMAIN_ID'])))
    side = Side(session, sys.argv[1])
    publisher = side.publisher('/back', QoS(history=HistoryPolicy.KEEP_ALL))
    side.subscription(
        '/there', lambda sample: publisher.publish(sample.payload), QoS(history=HistoryPolicy.KEEP_ALL)
    )
    side.subscription('/pace', lambda _: None, QoS())
    print('ready', flush=True)
    sys.stdin.readline()
    session.close()
"""


@pytest.fixture
def environment(alone: dict[str, str]) -> dict[str, str]:
    return alone | {'PYTHONPATH': os.pathsep.join([str(Path(__file__).parents[3])])}


@pytest.mark.slow
def test_sixty_four_megabytes_pass_both_ways(environment: dict[str, str]) -> None:
    session = TRANSPORT.open(SessionOptions(int(environment['ROS_DOMAIN_ID'])))
    try:
        side, came = Side(session, 'near'), Collector[Sample]()
        side.subscription('/back', came, KEEP_ALL)
        publisher = side.publisher('/there', KEEP_ALL)
        with Program(ECHO, 'far', env=environment) as far:
            far.expect('ready')
            side.graph.expect(EndpointKind.SUBSCRIPTION, '/there')
            side.graph.expect(EndpointKind.PUBLISHER, '/back')
            publisher.publish(b'met')
            came.expect(1)
            sent = os.urandom(1 << 20) * 64
            publisher.publish(sent)
            assert came.expect(2, 50.0)[-1].payload == sent
            far.write_line('')
            far.succeed()
    finally:
        session.close()


@pytest.mark.slow
def test_a_stopped_reliable_reader_holds_up_who_waits_for_it_and_nobody_else(
    environment: dict[str, str],
) -> None:
    """A second publisher to the same reader, with a history of ten, goes on at its own pace meanwhile."""
    session = TRANSPORT.open(SessionOptions(int(environment['ROS_DOMAIN_ID'])))
    all_ticked = threading.Event()

    def tick() -> None:
        for _ in range(100):
            pace.publish(b'x')
        all_ticked.set()

    def pour() -> None:
        for _ in range(40):
            waits.publish(bytes(100_000))

    try:
        side, came = Side(session, 'near'), Collector[Sample]()
        to_all, waits = side.publisher('/small', QoS()), side.publisher('/there', KEEP_ALL)
        pace = side.publisher('/pace', QoS())
        side.subscription('/small', came)
        with Program(ECHO, 'far', env=environment) as far:
            far.expect('ready')
            side.graph.expect(EndpointKind.SUBSCRIPTION, '/there')
            side.graph.expect(EndpointKind.SUBSCRIPTION, '/pace')
            far.send_signal(signal.SIGSTOP)
            blocked = threading.Thread(target=pour)
            blocked.start()
            ticker = threading.Thread(target=tick)
            ticker.start()
            for _ in range(200):
                to_all.publish(b'x')
            came.expect(200)
            ticked = all_ticked.wait(PATIENCE)
            held_up = blocked.is_alive()
            far.send_signal(signal.SIGCONT)
            blocked.join(PATIENCE)
            assert not blocked.is_alive()
            far.write_line('')
            far.succeed()
    finally:
        session.close()
    ticker.join(PATIENCE)
    assert ticked
    assert held_up, 'the stopped reader should have held it up'


@pytest.mark.slow
def test_a_killed_peer_is_gone_within_the_lease_that_it_announced(environment: dict[str, str]) -> None:
    session = TRANSPORT.open(SessionOptions(int(environment['ROS_DOMAIN_ID'])))
    try:
        side = Side(session, 'near')
        with Program(ECHO, 'far', env=environment | lease_variables(2.0)) as far:
            far.expect('ready')
            side.graph.expect(EndpointKind.NODE, '/far')
            side.graph.expect(EndpointKind.SUBSCRIPTION, '/there')
            far.kill()
            began = time.monotonic()
            side.graph.expect(EndpointKind.NODE, '/far', 0)
            side.graph.expect(EndpointKind.SUBSCRIPTION, '/there', 0)
            assert time.monotonic() - began < 9.0  # the lease where none is announced: 10 s
    finally:
        session.close()
