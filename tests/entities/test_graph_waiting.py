"""The queue of requests that wait for a server: when it looks who is there."""

from __future__ import annotations

from std_srvs.srv import Trigger

from goalwire.entities.graph_waiting import ServerWaitQueue
from goalwire.entities.node import NodeCore
from goalwire.entities.service import ServiceCore
from goalwire.entities.type_support import service_support
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.rules.qos import SERVICES_DEFAULT


class Watcher:
    """Counts how often somebody looks."""

    def __init__(self, node: NodeCore) -> None:
        self.looks = 0
        self._node = node
        self.queue = ServerWaitQueue(node.context, self.is_there, '/go')

    def is_there(self) -> bool:
        self.looks += 1
        return self._node.graph.has_service('/go', 'std_srvs/srv/Trigger')


def serve(node: NodeCore) -> ServiceCore:
    return ServiceCore(
        node,
        service_support(Trigger),
        'go',
        lambda _, response: response,
        SERVICES_DEFAULT,
        ReentrantCallbackGroup(),
    )


def test_a_server_that_was_seen_is_there_until_the_graph_changes(node: NodeCore) -> None:
    service, watcher = serve(node), Watcher(node)
    queue = watcher.queue
    assert [queue.has_server() for _ in range(3)] == [True] * 3
    assert watcher.looks == 1
    assert [server.name for server in queue.servers] == ['/go']
    service.destroy()
    assert not queue.has_server()
    serve(node)
    assert queue.has_server()


def test_a_server_that_is_missing_is_looked_for_each_time(node: NodeCore) -> None:
    watcher = Watcher(node)
    assert [watcher.queue.has_server() for _ in range(3)] == [False] * 3
    assert watcher.looks == 3


def test_who_serves_is_looked_for_again_where_a_connection_has_changed(node: NodeCore) -> None:
    serve(node)
    watcher = Watcher(node)
    assert watcher.queue.has_server()
    node.graph.connected()
    assert watcher.queue.has_server()
    assert watcher.looks == 2
