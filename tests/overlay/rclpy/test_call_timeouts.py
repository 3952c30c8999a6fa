"""Calls that end: a default time for programs written for rclpy, and what their calls raise then."""

from __future__ import annotations

import gc
import math
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, Spinner, result_of, wait_until
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.client import Client
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.task import Future
from std_srvs.srv import SetBool, Trigger

from goalwire.entities.pending_call import PENDING_LIMIT
from goalwire.errors import (
    DeadlineError,
    NoServerError,
    RCLError,
    ServerFailedError,
    ServerLostError,
    ShutDownError,
    TooManyCallsError,
)
from goalwire.logging import add_sink

TriggerClient = Client[Trigger.Request, Trigger.Response]


def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
    response.success = True
    return response


def error_of(future: Future[Any]) -> BaseException:
    """Wait for the exception that a future ends with."""
    assert future.wait(time.monotonic_ns() + int(PATIENCE * 1e9)), 'it stays pending'
    error = future.exception()
    assert error is not None
    return error


class Hanging:
    """A service whose callback holds on to its requests until it is let go."""

    def __init__(self, make_node: MakeNode, spin: Spin) -> None:
        self.began: Collector[None] = Collector()
        self._go_on = threading.Event()
        self.node = make_node('lamp')
        self.service = self.node.create_service(
            Trigger, 'hang', self._hang, callback_group=ReentrantCallbackGroup()
        )
        self.spinner: Spinner = spin(self.node, threads=4)

    def _hang(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.began(None)
        assert self._go_on.wait(PATIENCE)
        return answer(request, response)

    def let_go(self) -> None:
        self._go_on.set()


@pytest.fixture
def hanging(make_node: MakeNode, spin: Spin) -> Iterator[Hanging]:
    """A server that begins and does not end."""
    server = Hanging(make_node, spin)
    yield server
    server.let_go()


@pytest.fixture
def impatient(hanging: Hanging, make_node: MakeNode) -> TriggerClient:
    """A client of that server whose calls may take 50 ms."""
    client = make_node('hand').create_client(Trigger, 'hang')
    assert client.wait_for_service(PATIENCE)
    client.call_timeout = 0.05
    return client


def calls_of(client: TriggerClient) -> list[object]:
    """Return the calls that a client holds."""
    return [*client.timed, *client.pending]


def empty(client: TriggerClient) -> bool:
    """Whether a client holds nothing of calls, nor does its transport."""
    port: Any = client._port
    table = {**getattr(port, '_calls', {}), **getattr(port, 'waiting', {})}
    waits_for_servers = {} if client.wait_queue is None else client.wait_queue.waiting
    return not (client.pending or client.timed or waits_for_servers or table)


def test_a_call_to_a_server_that_hangs_ends_at_its_deadline(impatient: TriggerClient) -> None:
    begun = time.monotonic()
    with pytest.raises(
        DeadlineError, match=r"^service '/hang' of node '/lamp': no answer came in time; waited \d\.\d{3} s$"
    ) as e:
        impatient.call(Trigger.Request())
    assert time.monotonic() - begun >= 0.05
    assert (e.value.name, e.value.peers) == ('/hang', ('/lamp',))
    assert 0.05 <= e.value.waited < 1
    assert empty(impatient)


def test_a_future_ends_at_its_deadline_though_nobody_spins(impatient: TriggerClient) -> None:
    futures = [impatient.call_async(Trigger.Request()) for _ in range(5)]
    assert {type(error_of(future)) for future in futures} == {DeadlineError}
    assert empty(impatient)


def test_done_callbacks_and_coroutines_hear_of_the_deadline(
    impatient: TriggerClient, make_node: MakeNode, spin: Spin
) -> None:
    node, heard = make_node('hearing'), Collector[object]()
    client = node.create_client(Trigger, 'hang')
    client.call_timeout = 0.05

    async def ask() -> None:
        timer.cancel()
        client.call_async(Trigger.Request()).add_done_callback(lambda done: heard(done.exception()))
        try:
            await client.call_async(Trigger.Request())
        except DeadlineError as error:
            heard(error)

    timer = node.create_timer(0.001, ask)
    spin(node)
    assert {type(error) for error in heard.expect(2)} == {DeadlineError}


def test_a_call_waits_for_a_server_that_comes_in_time(make_node: MakeNode, spin: Spin) -> None:
    client = make_node().create_client(Trigger, 'late')
    client.call_timeout = PATIENCE
    early = client.call_async(Trigger.Request())
    server = make_node('server')
    server.create_service(Trigger, 'late', answer)
    spin(server)
    assert result_of(early).success
    assert calls_of(client) == []


def test_without_a_server_it_is_that_which_is_told(make_node: MakeNode) -> None:
    client = make_node().create_client(Trigger, 'nosuch')
    client.call_timeout = 0.03
    with pytest.raises(
        NoServerError, match=r"^service '/nosuch': no server came in domain \d+ \(\w+\); waited \d+\.\d{3} s$"
    ):
        client.call(Trigger.Request())
    assert isinstance(error_of(client.call_async(Trigger.Request())), NoServerError)
    client.call_timeout = 0.0
    assert isinstance(error_of(client.call_async(Trigger.Request())), NoServerError)
    assert empty(client)


def test_a_server_in_another_namespace_or_of_another_type_is_named(make_node: MakeNode) -> None:
    node, server = make_node('asker'), make_node('server', namespace='robot')
    server.create_service(Trigger, 'lamp', answer)
    client = node.create_client(Trigger, 'lamp')
    wait_until(node.context, lambda: node.count_services('/robot/lamp') == 1)
    client.call_timeout = 0.03
    with pytest.raises(NoServerError, match=r"did you mean '/robot/lamp' of the node '/robot/server'\?$"):
        client.call(Trigger.Request())
    with pytest.raises(NoServerError, match=r"no server came within 0.01 s; did you mean '/robot/lamp'"):
        client.call(Trigger.Request(), timeout_sec=0.01)
    other = node.create_client(SetBool, '/robot/lamp')
    other.call_timeout = 0.03
    with pytest.raises(
        NoServerError,
        match=r"; node '/robot/server' serves that name with the type std_srvs/srv/Trigger, "
        r"node '/asker' asks for std_srvs/srv/SetBool$",
    ):
        other.call(SetBool.Request())


def test_who_waits_for_a_service_in_vain_is_told_once_what_is_near(make_node: MakeNode) -> None:
    lines = Collector[str]()
    node, server = make_node('asker'), make_node('server', namespace='robot')
    server.create_service(Trigger, 'lamp', answer)
    client = node.create_client(Trigger, 'lamp')
    wait_until(node.context, lambda: node.count_services('/robot/lamp') == 1)
    with add_sink(lambda record: lines(record.message)):
        for _ in range(3):
            assert not client.wait_for_service(0.01)
        assert lines.items == [
            "service '/lamp': no server came; did you mean '/robot/lamp' of the node '/robot/server'?"
        ]
        assert not node.create_client(Trigger, 'gripper').wait_for_service(0.01)
        assert len(lines.items) == 1


def test_a_server_that_goes_is_told_at_once(impatient: TriggerClient, hanging: Hanging) -> None:
    impatient.call_timeout = math.inf
    future = impatient.call_async(Trigger.Request())
    hanging.began.expect(1)
    hanging.node.destroy_service(hanging.service)
    assert isinstance(error_of(future), ServerLostError)
    assert empty(impatient)
    hanging.let_go()
    hanging.spinner.expect_raised(InvalidHandle)


def test_what_a_callback_raises_reaches_its_client(make_node: MakeNode, spin: Spin) -> None:
    def fail(_: Trigger.Request, __: Trigger.Response) -> Trigger.Response:
        raise KeyError('bulb')

    server, client = make_node('lamp'), make_node().create_client(Trigger, 'fail')
    server.create_service(Trigger, 'fail', fail)
    client.call_timeout = PATIENCE
    spinner = spin(server)
    with pytest.raises(ServerFailedError, match="'/lamp': its callback failed: KeyError: 'bulb'; waited"):
        client.call(Trigger.Request())
    spinner.expect_raised(KeyError)


def test_an_answer_beats_its_deadline_and_leaves_nothing(make_node: MakeNode, spin: Spin) -> None:
    node, server = make_node(), make_node('server')
    server.create_service(Trigger, 'go', answer)
    spin(server)
    client = node.create_client(Trigger, 'go')
    node.handle.call_timeout = PATIENCE
    for _ in range(20):
        response = client.call(Trigger.Request())
        assert response is not None
        assert response.success
    assert result_of(client.call_async(Trigger.Request())).success
    assert calls_of(client) == []


def test_the_nearest_time_counts(context: Context, make_node: MakeNode) -> None:
    node = make_node()
    client = node.create_client(Trigger, 'go')
    found = [client.default_timeout]
    context.call_timeout = 3.0
    found.append(client.default_timeout)
    node.handle.call_timeout = 2.0
    found.append(client.default_timeout)
    client.call_timeout = 1.0
    found.append(client.default_timeout)
    assert found == [None, 3.0, 2.0, 1.0]
    client.call_timeout = math.nan
    with pytest.raises(ValueError, match='nan'):
        client.call(Trigger.Request())
    assert empty(client)


def test_a_call_with_a_time_of_its_own_ends_by_that_one(impatient: TriggerClient) -> None:
    with pytest.raises(TimeoutError, match=r'within 0\.01 s'):
        impatient.call(Trigger.Request(), timeout_sec=0.01)
    assert empty(impatient)


def test_giving_a_call_up_leaves_nothing(impatient: TriggerClient, make_node: MakeNode) -> None:
    impatient.call_timeout = math.inf
    waiting = make_node('other').create_client(Trigger, 'nosuch')
    waiting.call_timeout = math.inf
    for client in (impatient, waiting):
        cancelled, removed, lost = (client.call_async(Trigger.Request()) for _ in range(3))
        assert len(client.timed) == 3
        cancelled.cancel()
        client.remove_pending_request(removed)
        assert not removed.done()
        client.destroy()
        assert isinstance(error_of(lost), InvalidHandle)
        assert calls_of(client) == []


def test_shutdown_ends_the_calls_that_have_a_time(
    impatient: TriggerClient, make_node: MakeNode, context: Context
) -> None:
    impatient.call_timeout = math.inf
    waiting = make_node('other').create_client(Trigger, 'nosuch')
    waiting.call_timeout = 3600.0
    futures = [client.call_async(Trigger.Request()) for client in (impatient, waiting)]
    raised: Collector[BaseException] = Collector()

    def call() -> None:
        try:
            impatient.call(Trigger.Request())
        except ShutDownError as error:
            raised(error)

    thread = threading.Thread(target=call)
    thread.start()
    context.shutdown()
    assert {type(error_of(future)) for future in futures} == {ShutDownError}
    raised.expect(1)
    thread.join()


def test_neither_ctrl_c_nor_a_call_after_the_end_leaves_a_line_on_stderr(
    impatient: TriggerClient, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    impatient.call_timeout = 60.0

    def interrupt(*_: object) -> None:
        impatient.node.context.shutdown()
        raise KeyboardInterrupt

    monkeypatch.setattr('goalwire.entities.client.block_on', interrupt)
    with pytest.raises(KeyboardInterrupt):
        impatient.call(Trigger.Request())
    with pytest.raises(ShutDownError):
        _ = impatient.call_async(Trigger.Request())
    gc.collect()
    assert 'never retrieved' not in capfd.readouterr().err


def test_what_the_program_itself_closes_leaves_no_line_on_stderr(
    impatient: TriggerClient, make_node: MakeNode, context: Context, capfd: pytest.CaptureFixture[str]
) -> None:
    impatient.call_timeout = math.inf
    left = make_node('other').create_client(Trigger, 'nosuch')
    left.call_timeout = math.inf
    futures = [client.call_async(Trigger.Request()) for client in (impatient, left)]
    impatient.destroy()  # pending futures of this one end by that, of the other by the context's end
    context.shutdown()
    assert all(future.wait(time.monotonic_ns() + int(PATIENCE * 1e9)) for future in futures)
    del futures
    gc.collect()
    assert 'never retrieved' not in capfd.readouterr().err


def test_thousands_of_calls_that_nobody_answers_leave_nothing(impatient: TriggerClient) -> None:
    """In the small what benchmarks/dead_service.py does with a hundred thousand."""
    impatient.call_timeout = 0.02
    ours = ('goalwire-deadlines', 'goalwire-sends')
    for _ in range(10):
        futures = [impatient.call_async(Trigger.Request()) for _ in range(200)]
        assert {type(error_of(future)) for future in futures} == {DeadlineError}
        assert [thread.name for thread in threading.enumerate() if thread.name in ours] == [ours[0]]
    assert empty(impatient)
    context = impatient.node.context
    assert len(context.deadlines) < 200


def test_a_client_has_so_many_calls_and_no_more(impatient: TriggerClient) -> None:
    sent = impatient.call_async(Trigger.Request())
    impatient.timed = crowd = dict.fromkeys(range(PENDING_LIMIT), sent)  # type: ignore[assignment]
    with pytest.raises(TooManyCallsError, match="cannot call '/hang': 10000 calls of this client wait"):
        _ = impatient.call_async(Trigger.Request())
    impatient.timed = {}
    impatient.call_timeout = None
    impatient.pending = crowd  # type: ignore[assignment]
    with pytest.raises(TooManyCallsError):
        impatient.call(Trigger.Request())
    impatient.pending = {}
    sent.cancel()


@pytest.mark.parametrize(('text', 'seconds'), [('', None), ('2.5', 2.5), (' 3 ', 3.0), ('inf', math.inf)])
def test_a_variable_gives_every_call_of_the_process_a_time(
    monkeypatch: pytest.MonkeyPatch, text: str, seconds: float | None
) -> None:
    monkeypatch.setenv('GOALWIRE_CALL_TIMEOUT', text)
    context = Context()
    context.init(args=[])
    assert context.call_timeout == seconds
    context.shutdown()


@pytest.mark.parametrize('text', ['soon', '0', '-1', 'nan'])
def test_a_variable_that_is_no_time_is_refused(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv('GOALWIRE_CALL_TIMEOUT', text)
    with pytest.raises(RCLError, match=f"GOALWIRE_CALL_TIMEOUT is '{text}', which is not a time"):
        Context().init(args=[])
