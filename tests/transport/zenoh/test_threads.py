"""What zenoh's threads must never do: wait for themselves, or for the GIL while it is held for them."""

from __future__ import annotations

from helpers.collector import Collector
from helpers.processes import Program

from goalwire.protocol.qos import DurabilityPolicy, QoS
from goalwire.transport.contract import EndpointKind, Sample

from .conftest import OpenSide

LASTING = QoS(depth=30, durability=DurabilityPolicy.TRANSIENT_LOCAL)

LATE = """
import os, threading
from goalwire.protocol.qos import DurabilityPolicy, QoS
from goalwire.transport.contract import Endpoint, EndpointKind, NodeName, SessionOptions
from goalwire.transport.zenoh import TRANSPORT

came = threading.Semaphore(0)
qos = QoS(depth=30, durability=DurabilityPolicy.TRANSIENT_LOCAL)
map_ = Endpoint(EndpointKind.SUBSCRIPTION, '/map', 'std_msgs/msg/String', 'RIHS01_' + 'a1' * 32, qos)
session = TRANSPORT.open(SessionOptions(int(os.environ['ROS_DOMAIN_ID'])))
session.node(NodeName('late')).subscription(map_, lambda sample: came.release())
for number in range(30):
    assert came.acquire(timeout=10), f'{number} of 30 came'
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
        late.expect('all', timeout=15.0)
        late.succeed()


def test_lasting_publishers_are_taken_back_while_another_session_listens(open_side: OpenSide) -> None:
    """Zenoh holds the GIL while it takes one back; a callback that waits for it must not hold that up."""
    ours, theirs = open_side('ours'), open_side('theirs')
    samples: Collector[Sample] = Collector()
    theirs.subscription('/map', samples, LASTING)
    ours.graph.expect(EndpointKind.SUBSCRIPTION, '/map')
    for number in range(200):
        publisher = ours.publisher('/map', LASTING)
        publisher.publish(str(number).encode())
        publisher.close()
    assert samples.expect(1)
