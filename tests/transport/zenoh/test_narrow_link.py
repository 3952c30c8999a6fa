"""Many endpoints meet over a link whose sockets hold little, as between two machines."""

from __future__ import annotations

import pytest
from helpers.isolation import free_port
from helpers.processes import Program
from helpers.wire import SeenGraph

from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind

from .conftest import OpenSide

NUMBER = 700
"""The number of endpoints. Their declarations are more than Zenoh's own queue and the sockets hold."""

SMALL = '#so_sndbuf=8192\\u003bso_rcvbuf=8192'
"""The ';' within an endpoint would end the setting."""

OTHERS = """
import os, sys, threading
from goalwire.rules.qos import QoS
from goalwire.transport.contract import (
    Endpoint, EndpointKind, GraphEntity, GraphListener, NodeName, SessionOptions,
)
from goalwire.transport.zenoh import TRANSPORT

class Listener(GraphListener):
    def appeared(self, entity: GraphEntity) -> None:
        if entity.name == '/ours':
            came.release()

    def vanished(self, entity: GraphEntity) -> None:
        pass

came = threading.Semaphore(0)
session = TRANSPORT.open(SessionOptions(int(os.environ['ROS_DOMAIN_ID'])))
session.watch_graph(Listener())
node = session.node(NodeName('others'))
theirs = Endpoint(EndpointKind.PUBLISHER, '/theirs', 'std_msgs/msg/String', 'RIHS01_' + 'a1' * 32, QoS())
for _ in range(int(sys.argv[1])):
    node.publisher(theirs)
for number in range(int(sys.argv[1])):
    assert came.acquire(timeout=60), f'{number} came'
print('met', flush=True)
sys.stdin.readline()
session.close()
"""


def over(setting: str, port: int) -> dict[str, str]:
    """Return the environment of one end of a direct link."""
    return {
        'GOALWIRE_ROUTER': 'off',
        'ZENOH_ROUTER_CHECK_ATTEMPTS': '-1',
        'ZENOH_CONFIG_OVERRIDE': f'{setting}/endpoints=["tcp/127.0.0.1:{port}{SMALL}"]',
    }


def test_hundreds_of_endpoints_meet_over_a_link_that_holds_little(
    world: dict[str, str], open_side: OpenSide, monkeypatch: pytest.MonkeyPatch
) -> None:
    port = free_port()
    for name, setting in over('listen', port).items():
        monkeypatch.setenv(name, setting)
    ours, graph = open_side('ours'), SeenGraph()
    for _ in range(NUMBER):
        ours.publisher('/ours', QoS())
    ours.session.watch_graph(graph)
    with Program(OTHERS, str(NUMBER), env=world | over('connect', port)) as others:
        others.expect('met')
        graph.expect(EndpointKind.PUBLISHER, '/theirs', NUMBER)
        others.write_line('')
        others.succeed()
