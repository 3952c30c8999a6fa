"""Requests that are sent again."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from time import time_ns
from typing import Any

import pytest
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import result_of
from std_srvs.srv import Trigger

from goalwire.entities.client import ClientCore
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import service_support
from goalwire.errors import DeadlineError, NoServerError, ServerFailedError, ServerLostError
from goalwire.execution.time.steady_clock import STEADY
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.rules.qos import SERVICES_DEFAULT
from goalwire.rules.retries import CallAttempt, Retry
from goalwire.transport.contract import Endpoint, EndpointKind, Port, Request, Sample

SUPPORT = service_support(Trigger)
QUICK = Retry(first_delay=0.001, budget=100.0)


class Server:
    """Takes requests as they come from the wire; `act` decides what becomes of the first, second, …"""

    def __init__(self, node: NodeCore, *acts: str) -> None:
        self._node = node
        self._acts = list(acts)
        self.requests: Collector[Request] = Collector()
        self._port: Port | None = None
        self.open()

    def open(self) -> None:
        endpoint = Endpoint(
            EndpointKind.SERVICE, '/go', SUPPORT.type_name, SUPPORT.type_hash, SERVICES_DEFAULT
        )
        self._port = self._node.port.service(endpoint, self._take)

    def close(self) -> None:
        assert self._port is not None
        self._port.close()

    def _take(self, request: Request) -> None:
        act = self._acts.pop(0) if self._acts else 'answer'
        self.requests(request)
        if act == 'answer':
            request.reply(SUPPORT.encode_response(Trigger.Response(success=True)))
        elif act != 'hang':
            request.cancel('' if act == 'lose' else act)


@pytest.fixture
def client(node: NodeCore) -> Iterator[ClientCore]:
    client = ClientCore(node, SUPPORT, 'go', SERVICES_DEFAULT)
    client.retry = QUICK
    yield client
    assert client.pending == {}
    assert len(client.timed) == 0


def error_of(future: Any) -> BaseException:
    assert future.wait(STEADY.now() + int(PATIENCE * 1e9)), 'it stays pending'
    error = future.exception()
    assert isinstance(error, BaseException)
    return error


def test_a_request_that_was_lost_is_sent_again(node: NodeCore, client: ClientCore) -> None:
    server = Server(node, 'lose', 'lose', 'answer')
    assert result_of(client.begin(Trigger.Request(), PATIENCE)).success
    assert len(server.requests.items) == 3
    server.close()


def test_the_last_error_is_told_with_the_number_of_attempts(node: NodeCore, client: ClientCore) -> None:
    server = Server(node, 'lose', 'lose', 'lose', 'answer')
    error = error_of(client.begin(Trigger.Request(), PATIENCE))
    assert isinstance(error, ServerLostError)
    assert str(error).endswith(' s, 3 attempts')
    assert len(server.requests.items) == 3
    server.close()


def test_an_attempt_may_have_a_time_of_its_own(node: NodeCore, client: ClientCore) -> None:
    client.retry = replace(QUICK, timeout=0.02)
    server = Server(node, 'hang', 'answer')
    assert result_of(client.begin(Trigger.Request(), PATIENCE)).success
    first, _ = server.requests.items
    first.reply(SUPPORT.encode_response(Trigger.Response()))  # too late: nobody hears it
    server.close()


def test_a_reply_to_an_earlier_attempt_leaves_nothing_of_a_later_one(
    node: NodeCore, client: ClientCore
) -> None:
    server = Server(node, 'lose', 'hang')
    call = client.begin(Trigger.Request(), PATIENCE)
    first, _ = server.requests.expect(2)
    sent = threading.Event()
    node.context.sends.soon(TimerEntry(sent.set))  # on the thread that has sent the second
    assert sent.wait(PATIENCE)
    assert list(client.pending) == [2]
    reply = SUPPORT.encode_response(Trigger.Response(success=True))
    now = time_ns()
    call.on_reply(
        Sample(reply, first.sample.sequence, now, now, first.sample.gid)
    )  # it was being handed over
    assert result_of(call).success
    server.close()


def test_all_attempts_share_one_deadline(node: NodeCore, client: ClientCore) -> None:
    client.retry = replace(QUICK, attempts=1000, timeout=0.02)
    server = Server(node, *['hang'] * 1000)
    error = error_of(client.begin(Trigger.Request(), 0.4))
    assert isinstance(error, DeadlineError)
    assert 1 < len(server.requests.items) <= 20
    server.close()


def test_a_callback_that_failed_is_not_asked_again(node: NodeCore, client: ClientCore) -> None:
    server = Server(node, 'its callback failed: ValueError', 'answer')
    assert isinstance(error_of(client.begin(Trigger.Request(), PATIENCE)), ServerFailedError)
    assert len(server.requests.items) == 1
    server.close()


def test_without_retries_a_lost_request_is_lost(node: NodeCore, client: ClientCore) -> None:
    client.retry = None
    server = Server(node, 'lose', 'answer')
    assert isinstance(error_of(client.begin(Trigger.Request(), PATIENCE)), ServerLostError)
    server.close()


def test_a_server_that_comes_back_gets_the_request_again(node: NodeCore, client: ClientCore) -> None:
    server = Server(node, 'hang')
    future = client.begin(Trigger.Request(), PATIENCE)
    server.close()
    assert not future.done()
    server.open()
    assert result_of(future).success


def test_a_server_that_does_not_come_back_is_what_is_told(node: NodeCore, client: ClientCore) -> None:
    server = Server(node, 'hang')
    future = client.begin(Trigger.Request(), 0.3)
    server.close()
    assert isinstance(error_of(future), NoServerError)


def test_a_call_that_is_given_up_between_two_attempts_is_not_sent_again(
    node: NodeCore, client: ClientCore
) -> None:
    client.retry = replace(QUICK, first_delay=0.02)
    server = Server(node, 'lose', 'answer')
    given_up = client.begin(Trigger.Request(), PATIENCE)
    given_up.cancel()
    assert result_of(client.begin(Trigger.Request(), PATIENCE)).success
    assert result_of(client.begin(Trigger.Request(), PATIENCE)).success
    assert len(server.requests.items) == 3
    server.close()


def test_a_sick_server_is_spared_once_the_budget_is_used_up(node: NodeCore, client: ClientCore) -> None:
    client.retry = replace(QUICK, budget=10.0)
    server = Server(node, *['lose'] * 1000)
    for _ in range(50):
        assert isinstance(error_of(client.begin(Trigger.Request(), PATIENCE)), ServerLostError)
    assert 50 < len(server.requests.items) <= 55
    server.close()


def test_a_hook_hears_of_every_attempt_on_the_executor(spun: NodeCore) -> None:
    records: Collector[CallAttempt] = Collector()
    client = ClientCore(spun, SUPPORT, 'go', SERVICES_DEFAULT)
    client.retry = replace(QUICK, on_attempt=records)
    server = Server(spun, 'lose', 'answer', 'lose', 'lose', 'lose')
    assert result_of(client.begin(Trigger.Request(), PATIENCE)).success
    error = error_of(client.begin(Trigger.Request(), PATIENCE))
    assert isinstance(error, ServerLostError)
    told = records.expect(5)
    assert [record.number for record in told] == [1, 2, 1, 2, 3]
    assert [type(record.error) for record in told] == [ServerLostError, type(None), *[ServerLostError] * 3]
    assert [record.retry_in is None for record in told] == [False, True, False, False, True]
    assert {(record.name, record.peers) for record in told} == {('/go', ('/node',))}
    assert all(record.began >= 0 and record.lasted >= 0 for record in told)
    assert threading.get_ident() not in records.threads
    with pytest.raises(AttributeError):
        told[0].number = 2  # type: ignore[misc]
    server.close()


def test_a_hook_that_raises_is_logged_and_spares_the_call(
    spun: NodeCore, capfd: pytest.CaptureFixture[str]
) -> None:
    heard: Collector[CallAttempt] = Collector()

    def fail(record: CallAttempt) -> None:
        heard(record)
        raise ValueError('a mistake')

    client = ClientCore(spun, SUPPORT, 'go', SERVICES_DEFAULT)
    client.retry = replace(QUICK, on_attempt=fail)
    server = Server(spun)
    assert result_of(client.begin(Trigger.Request(), PATIENCE)).success
    heard.expect(1)
    assert result_of(client.call_async(Trigger.Request())).success
    heard.expect(2)
    assert "Service '/go': on_attempt failed: ValueError('a mistake')" in capfd.readouterr().err
    server.close()


def test_a_hook_hears_of_the_attempt_that_the_deadline_ended(spun: NodeCore) -> None:
    records: Collector[CallAttempt] = Collector()
    client = ClientCore(spun, SUPPORT, 'go', SERVICES_DEFAULT)
    client.retry = replace(QUICK, on_attempt=records)
    server = Server(spun, 'hang')
    assert isinstance(error_of(client.begin(Trigger.Request(), 0.02)), DeadlineError)
    (record,) = records.expect(1)
    assert isinstance(record.error, DeadlineError)
    assert record.retry_in is None
    server.close()
