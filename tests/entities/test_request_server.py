"""The receiving end of a service: what happens when requests come faster than they are answered."""

from __future__ import annotations

import pytest
from helpers.cores import Front

from goalwire.entities import request_server
from goalwire.entities.client import ClientCore
from goalwire.entities.node import NodeCore
from goalwire.entities.service import ServiceCore
from goalwire.entities.type_support import service_support
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.single_threaded import SingleThreadedExecutor
from goalwire.protocol.qos import SERVICES_DEFAULT


def test_beyond_the_limit_requests_are_refused_counted_and_logged_once(
    node: NodeCore, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from std_srvs.srv import Trigger

    monkeypatch.setattr(request_server, 'QUEUE_LIMIT', 5)
    support, group = service_support(Trigger), ReentrantCallbackGroup()
    service = ServiceCore(node, support, 'go', lambda _, response: response, SERVICES_DEFAULT, group)
    client = ClientCore(node, support, 'go', SERVICES_DEFAULT)
    futures = [client.call_async(Trigger.Request()) for _ in range(8)]
    assert service._server.refused == 3
    assert client.unanswered == 3
    with SingleThreadedExecutor(context=node.context) as executor:
        executor.add_node(Front(node))
        executor.spin_until_future_complete(futures[4], 10)
    assert [future.done() for future in futures] == [True] * 5 + [False] * 3
    assert client.pending == {}
    printed = capfd.readouterr().err
    assert printed.count("[node]: Service '/go': 5 requests wait already") == 1
    assert printed.count("Service '/go': no server answered") == 1


def test_destroying_gives_up_what_waits(node: NodeCore) -> None:
    from std_srvs.srv import Trigger

    support, group = service_support(Trigger), ReentrantCallbackGroup()
    service = ServiceCore(node, support, 'go', lambda _, response: response, SERVICES_DEFAULT, group)
    client = ClientCore(node, support, 'go', SERVICES_DEFAULT)
    futures = [client.call_async(Trigger.Request()) for _ in range(3)]
    service.destroy()
    service.destroy()
    assert service.destroyed
    assert client.unanswered == 3
    assert not any(future.done() or future.cancelled() for future in futures)
    assert client.pending == {}
