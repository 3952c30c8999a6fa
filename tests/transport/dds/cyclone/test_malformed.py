"""Bytes that are not a message, put on the wire by a raw writer of another process, are rejected and counted.

They never become a default message, and are never read past their end.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from example_interfaces.srv import AddTwoInts
from helpers.collector import Collector
from helpers.processes import Program
from helpers.spinning import Spinner
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header as Stamp

from goalwire.transport.dds.cyclone.session import CycloneSession
from goalwire.transport.dds.service_header import ENCAPSULATION_SIZE, SIZE, Header, wrap

POUR = """
    import os, sys
    from ctypes import c_uint64
    from helpers.stranger import Stranger, write_unpadded
    from goalwire.rules.qos import QoS
    from goalwire.transport.dds.cyclone.configuration import (domain_configuration)
    from goalwire.transport.dds.cyclone.library import load
    from goalwire.transport.dds.cyclone.status import PUBLICATION_MATCHED

    domain = int(os.environ['ROS_DOMAIN_ID'])
    library = load()
    library.dds_create_domain(domain, domain_configuration(domain).encode())
    stranger = Stranger(domain)
    writer = stranger.writer(sys.argv[1], sys.argv[2], QoS(depth=10_000))
    waits = library.dds_create_waitset(stranger.participant.handle)
    library.dds_set_status_mask(writer.handle, PUBLICATION_MATCHED)
    library.dds_waitset_attach(waits, writer.handle, 1)
    while library.dds_get_matched_subscriptions(writer.handle, (c_uint64 * 1)(), 1) < 1:
        library.dds_waitset_wait(waits, None, 0, 10_000_000_000)
    writer.write(bytes.fromhex(sys.argv[3]))
    library.dds_wait_for_acks(writer.handle, 10_000_000_000)  # so the reader's side knows of us too
    for line in sys.stdin:
        print('written' if write_unpadded(writer, bytes.fromhex(line)) else 'refused', flush=True)
    stranger.close()
"""
MESSAGE = JointState(
    header=Stamp(frame_id='base'), name=['hip', 'knee'], position=[0.5, -1.5], velocity=[2.5], effort=[7.5]
)
FIRST, LAST = JointState(name=['first']), JointState(name=['last'])
HEADLESS = ENCAPSULATION_SIZE + SIZE
LENGTHS = (8, 20, 24, 32, 40)
"""Where MESSAGE has lengths, counted from its body: of frame_id, of name and its two items, of position."""


@pytest.fixture
def node(alone: dict[str, str]) -> Iterator[Node]:
    """A node that spins, in its own context."""
    context = Context()
    with rclpy.init(context=context):
        node = Node('near', context=context)
        with SingleThreadedExecutor(context=context) as executor, Spinner(executor, node):
            yield node
        node.destroy_node()


def pour(env: dict[str, str], topic: str, type_name: str, first: bytes, payloads: list[bytes]) -> int:
    """Write each payload on the wire; return how many the library of the writer let pass.

    `first` is written before the reader need know the writer: it may arrive or not.
    """
    env = env | {'PYTHONPATH': str(Path(__file__).parents[3])}
    with Program(POUR, topic, type_name, first.hex(), env=env) as program:
        for payload in payloads:
            program.write_line(payload.hex())
        return sum(program.expect('written|refused').group() == 'written' for _ in payloads)


def cut(sound: bytes) -> list[bytes]:
    """Return a message cut off at every byte. DDS itself fills up the last four, so there nobody can tell."""
    return [sound[:size] for size in range(5, len(sound) - 3)]


def overlong(sound: bytes) -> list[bytes]:
    """Return a message with each of its lengths, in turn, set to the largest there is."""
    return [sound[: 4 + at] + b'\xff\xff\xff\xff' + sound[8 + at :] for at in LENGTHS]


def test_a_malformed_message_reaches_no_callback(node: Node, alone: dict[str, str]) -> None:
    came: Collector[JointState] = Collector()
    subscription = node.create_subscription(JointState, 'joints', came, 1000)
    sound = serialize_message(MESSAGE)
    broken = [*cut(sound), *overlong(sound), b'\0\7\0\0' + sound[4:]]
    payloads = [*broken, sound, serialize_message(LAST)]
    type_name = 'sensor_msgs::msg::dds_::JointState_'
    assert pour(alone, 'rt/joints', type_name, serialize_message(FIRST), payloads) == len(payloads)
    arrived = came.wait_for(lambda items: LAST in items)
    assert [each for each in arrived if each != FIRST] == [MESSAGE, LAST]
    assert subscription.rejected == len(broken)


def test_a_malformed_request_reaches_no_callback(node: Node, alone: dict[str, str]) -> None:
    came: Collector[AddTwoInts.Request] = Collector()

    def add(request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        came(request)
        return response

    service = node.create_service(AddTwoInts, 'add', add)
    first, sound = (headed(AddTwoInts.Request(a=a, b=4)) for a in (1, 3))
    broken = cut(sound)
    type_name = 'example_interfaces::srv::dds_::AddTwoInts_Request_'
    assert pour(alone, 'rq/addRequest', type_name, first, [*broken, sound]) == len(broken) + 1
    arrived = came.wait_for(lambda items: AddTwoInts.Request(a=3, b=4) in items)
    assert {each.a for each in arrived} <= {1, 3}
    headless = sum(len(payload) <= HEADLESS for payload in broken)
    session = node.context.session
    assert isinstance(session, CycloneSession)
    assert session.statistics()['request'] == headless
    assert service._server.rejected == len(broken) - headless


def headed(request: AddTwoInts.Request) -> bytes:
    """Return a request as Cyclone DDS sends it."""
    return wrap(Header(7, 1), serialize_message(request))
