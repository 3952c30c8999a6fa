"""A process that is stopped, and so reads nothing, beside one that reads: who gets which large messages."""

from __future__ import annotations

import signal

from helpers.processes import Program
from helpers.wire import Side

from goalwire.logging import LogRecord
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind

DEPTH, NUMBER = 3, 40
MEGABYTE = 1 << 20

READER = """
import os, sys
from goalwire.rules.qos import QoS
from goalwire.transport.contract import Endpoint, EndpointKind, NodeName, SessionOptions
from goalwire.transport.zenoh import TRANSPORT

session = TRANSPORT.open(SessionOptions(int(os.environ['ROS_DOMAIN_ID'])))
kind, text = EndpointKind.SUBSCRIPTION, 'std_msgs/msg/String'
endpoint = Endpoint(kind, '/chatter', text, 'RIHS01_' + 'a1' * 32, QoS(depth=100))
session.node(NodeName('reader')).subscription(endpoint, lambda sample: print('got', sample.payload[0]))
sys.stdin.readline()
session.close()
"""


def test_a_stopped_reader_takes_no_large_message_away_from_others(
    goalwire_side: Side, world: dict[str, str], records: list[LogRecord]
) -> None:
    port = goalwire_side.publisher('/chatter', QoS(depth=DEPTH))
    with Program(READER, env=world) as healthy, Program(READER, env=world) as stopped:
        goalwire_side.graph.expect(EndpointKind.SUBSCRIPTION, '/chatter', 2)
        port.publish(bytes((0,)))
        healthy.expect('got 0$')
        stopped.expect('got 0$')
        stopped.send_signal(signal.SIGSTOP)
        for number in range(1, NUMBER):
            port.publish(bytes((number,)) + bytes(MEGABYTE))
            healthy.expect(f'got {number}$')
        port.publish(bytes((NUMBER,)))
        healthy.expect(f'got {NUMBER}$')  # on this link, nothing large is in the way of the small message
        dropped = port.port.dropped
        assert dropped > 0
        stopped.send_signal(signal.SIGCONT)
        stopped.expect(f'got {NUMBER}$')
        came = [int(line.removeprefix('got ')) for line in stopped.output.splitlines()]
        assert came[-DEPTH:] == list(range(NUMBER + 1 - DEPTH, NUMBER + 1))
        assert came == sorted(came)
        assert len(came) + dropped == NUMBER + 1
        assert port.port.dropped == dropped
    (record,) = records
    assert f'a message of {MEGABYTE + 1} bytes was dropped' in record.message
    assert 'history depth' in record.message
