"""The receiving end of a service: what happens when requests come faster than they are answered."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest
from helpers.cores import Front
from helpers.patience import PATIENCE
from helpers.spinning import Spinner

from goalwire.entities import request_server
from goalwire.entities.client import ClientCore
from goalwire.entities.node import NodeCore
from goalwire.entities.service import ServiceCore
from goalwire.entities.type_support import service_support
from goalwire.execution.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.rules.qos import SERVICES_DEFAULT


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
    assert printed.count("[node]: Service '/go': a request was refused (5 requests wait already)") == 1
    assert printed.count("Service '/go': the server gave no answer (refused: 5 requests wait already)") == 1


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


@pytest.fixture(params=[SingleThreadedExecutor, MultiThreadedExecutor])
def make_executor(request: pytest.FixtureRequest) -> Callable[..., Executor]:
    """Make either kind."""
    kind: Callable[..., Executor] = request.param
    return kind


def test_a_request_whose_coroutine_waits_at_the_executors_shutdown_is_given_up(
    node: NodeCore, make_executor: Callable[..., Executor]
) -> None:
    from std_srvs.srv import Trigger

    begun = threading.Event()

    async def for_ever(_: Any, response: Any) -> Any:
        begun.set()
        await asyncio.sleep(3600)
        return response

    support, group = service_support(Trigger), MutuallyExclusiveCallbackGroup()
    ServiceCore(node, support, 'go', for_ever, SERVICES_DEFAULT, group)
    client = ClientCore(node, support, 'go', SERVICES_DEFAULT)
    with Spinner(make_executor(context=node.context), Front(node)):
        assert client.call_async(Trigger.Request()).pending()
        assert begun.wait(PATIENCE)
        assert client.unanswered == 0
    assert client.unanswered == 1
    assert client.pending == {}


def test_a_request_whose_coroutine_never_began_at_the_executors_shutdown_is_given_up(
    node: NodeCore, make_executor: Callable[..., Executor], monkeypatch: pytest.MonkeyPatch
) -> None:
    from std_srvs.srv import Trigger

    executor = make_executor(context=node.context)

    async def for_ever(response: Any) -> Any:
        await asyncio.sleep(3600)
        return response

    def too_late(_: Any, response: Any) -> Any:
        executor.shutdown()
        return for_ever(response)

    support, group = service_support(Trigger), MutuallyExclusiveCallbackGroup()
    ServiceCore(node, support, 'go', too_late, SERVICES_DEFAULT, group)
    client = ClientCore(node, support, 'go', SERVICES_DEFAULT)
    given_up = threading.Event()
    monkeypatch.setattr(client, 'report_unanswered', lambda _: given_up.set())
    with Spinner(executor, Front(node)):
        assert client.call_async(Trigger.Request()).pending()
        assert given_up.wait(PATIENCE)
    assert client.pending == {}


@pytest.mark.parametrize(
    ('does', 'reason'), [('fail', 'its callback failed: ValueError: no bulb'), ('reject', 'rejected: ')]
)
def test_a_client_is_told_why_it_gets_no_answer(
    node: NodeCore, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, does: str, reason: str
) -> None:
    from std_srvs.srv import SetBool

    def fail(_: Any, __: Any) -> Any:
        raise ValueError('no bulb')

    support = service_support(SetBool)
    service = ServiceCore(node, support, 'go', fail, SERVICES_DEFAULT, ReentrantCallbackGroup())
    client = ClientCore(node, support, 'go', SERVICES_DEFAULT)
    if does == 'reject':
        monkeypatch.setattr(client, '_encode', lambda _: b'\x00\x01\x00\x00')
    for _ in range(2):
        _ = client.call_async(SetBool.Request())
        with suppress(ValueError):
            service._server.work_off()
    told = [line for line in capfd.readouterr().err.splitlines() if 'gave no answer' in line]
    assert [f"Service '/go': the server gave no answer ({reason}" in line for line in told] == [True]
    assert client.unanswered == 2
