"""Zenoh's threads must never wait for themselves, or for the GIL while it is held for them."""

from __future__ import annotations

from threading import Event, Thread

from helpers.processes import Program

from goalwire.rules.qos import DurabilityPolicy, QoS

from .conftest import OpenSide, on_both

pytestmark = on_both

LASTING = QoS(depth=30, durability=DurabilityPolicy.TRANSIENT_LOCAL)

LATE = """
import os, sys, threading
from goalwire.rules.qos import DurabilityPolicy, QoS
from goalwire.transport.contract import Endpoint, EndpointKind, NodeName, Sample, SessionOptions
from goalwire.transport.zenoh import TRANSPORT

pauses = len(sys.argv) > 1
came = threading.Semaphore(0)

def take(sample: Sample) -> None:
    global pauses
    if pauses:
        pauses = False
        print('pausing', flush=True)
        sys.stdin.readline()
    came.release()

qos = QoS(depth=30, durability=DurabilityPolicy.TRANSIENT_LOCAL)
map_ = Endpoint(EndpointKind.SUBSCRIPTION, '/map', 'std_msgs/msg/String', 'RIHS01_' + 'a1' * 32, qos)
session = TRANSPORT.open(SessionOptions(int(os.environ['ROS_DOMAIN_ID'])))
session.node(NodeName('late')).subscription(map_, take)
for number in range(30):
    assert came.acquire(timeout=60), f'{number} of 30 came'
print('all', flush=True)
session.close()
"""


def test_a_long_history_reaches_a_late_process_without_stopping_the_sender(
    world: dict[str, str], open_side: OpenSide
) -> None:
    """30 MB of history are far more than zenoh's queue holds; its receiving thread waits for room there."""
    ours = open_side('ours')
    publisher = ours.publisher('/map', LASTING)
    for _ in range(30):
        publisher.publish(bytes(1_000_000))
    with Program(LATE, env=world) as late:
        late.expect('all')
        late.succeed()


def test_a_late_process_that_pauses_while_history_comes_gets_all_of_it(
    world: dict[str, str], open_side: OpenSide
) -> None:
    """Zenoh's receiving thread, which waits for room, is not the one that learns when the socket has some."""
    ours, has_room = open_side('ours'), Event()
    publisher = ours.publisher('/map', LASTING)
    for _ in range(30):
        publisher.publish(bytes(1_000_000))

    def publish() -> None:
        publisher.publish(bytes(1_000_000))
        has_room.set()

    with Program(LATE, 'pausing', env=world) as late:
        late.expect('pausing')
        one_more = Thread(target=publish)
        one_more.start()
        assert not has_room.wait(0.3)  # it waits behind the history, and so does the receiving thread
        late.write_line('')
        late.expect('all')
        late.succeed()
        one_more.join()


TAKE_BACK = """
import json, os
import zenoh
from zenoh import ext
from goalwire.transport.zenoh import threads

port = os.environ['GOALWIRE_ROUTER_PORT']

def open_session(listen, connect):
    settings = {
        'mode': 'peer',
        'listen': {'endpoints': listen},
        'connect': {'endpoints': connect},
        'timestamping': {'enabled': True},
        'scouting': {'delay': 100, 'multicast': {'enabled': False}},
        'transport': {'shared_memory': {'enabled': False}},
    }
    return threads.open_session(zenoh.Config.from_json5(json.dumps(settings)))

def direct():
    return zenoh.handlers.Callback(lambda sample: None, indirect=False)

ours = open_session([f'tcp/127.0.0.1:{port}'], [])
theirs = open_session([], [f'tcp/127.0.0.1:{port}'])
theirs.liveliness().declare_subscriber('**', direct(), history=True)
for number in range(200):
    heartbeats = ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=0.5)
    publisher = ext.declare_advanced_publisher(
        ours, 'a/b', cache=ext.CacheConfig(5), sample_miss_detection=heartbeats, publisher_detection=True
    )
    token = ours.liveliness().declare_token(f'x/{number}')
    publisher.put(b'x')
    token.undeclare()
    publisher.undeclare()
print('done', flush=True)
theirs.close()
ours.close()
"""


def test_a_lasting_publisher_is_taken_back_while_a_callback_wants_the_gil(world: dict[str, str]) -> None:
    """Zenoh holds the GIL while it takes one back, and waits for a task of its upkeep thread."""
    with Program(TAKE_BACK, env=world) as taking_back:
        taking_back.expect('done')
        taking_back.succeed()
