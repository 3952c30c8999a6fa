"""Orders of events that are rare, made certain: nothing is lost, nothing is reported that is not so."""

from __future__ import annotations

import threading
from typing import Any
from weakref import ref

import pytest
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import result_of
from std_srvs.srv import Trigger

from goalwire.entities.actions.client import ActionClientCore
from goalwire.entities.actions.server import ActionServerCore
from goalwire.entities.actions.server_goal_handle import (
    ActionCallbacks,
    CancelResponse,
    GoalResponse,
    ServerGoalHandle,
)
from goalwire.entities.client import ClientCore
from goalwire.entities.node import NodeCore
from goalwire.entities.service import ServiceCore
from goalwire.entities.type_support import action_support, service_support
from goalwire.errors import TransportError
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.time.steady_clock import STEADY
from goalwire.rules.goals import wire
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.qos import SERVICES_DEFAULT
from goalwire.transport.contract import ClientPort, Endpoint, EndpointKind, NodePort, Request, Sample

TRIGGER, FIBONACCI = service_support(Trigger), action_support(Fibonacci)


def execute(handle: ServerGoalHandle) -> Fibonacci.Result:
    handle.publish_feedback(Fibonacci.Feedback(sequence=[handle.request.order]))
    handle.succeed()
    return Fibonacci.Result(sequence=[handle.request.order])


CALLBACKS = ActionCallbacks(
    execute, lambda _: GoalResponse.ACCEPT, lambda handle: handle.execute(), lambda _: CancelResponse.ACCEPT
)


def action_server(node: NodeCore, callbacks: ActionCallbacks = CALLBACKS) -> ActionServerCore:
    return ActionServerCore(node, FIBONACCI, 'fib', callbacks, ReentrantCallbackGroup())


def action_client(node: NodeCore) -> ActionClientCore:
    return ActionClientCore(node, FIBONACCI, 'fib', ReentrantCallbackGroup())


def test_a_request_that_comes_while_its_service_is_being_made_is_answered(spun: NodeCore) -> None:
    client = ClientCore(spun, TRIGGER, 'go', SERVICES_DEFAULT)
    futures: list[Any] = []

    def call_as_soon_as_possible() -> None:
        if client.server_is_there() and not futures:
            futures.append(client.call_async(Trigger.Request()))
            assert futures[0].wait(STEADY.now() + 10**10)

    watch = spun.graph.on_change(call_as_soon_as_possible)
    ServiceCore(spun, TRIGGER, 'go', lambda _, response: response, SERVICES_DEFAULT, ReentrantCallbackGroup())
    watch.close()
    assert [future.done() for future in futures] == [True]


def test_a_goal_that_comes_while_its_server_is_being_made_is_executed(spun: NodeCore) -> None:
    client = action_client(spun)
    sent: list[Any] = []

    def send_as_soon_as_possible() -> None:
        if spun.graph.has_service('/fib/_action/send_goal', FIBONACCI.send_goal.type_name) and not sent:
            sent.append(client.send(Fibonacci.Goal(order=3)))
            result_of(sent[0])

    watch = spun.graph.on_change(send_as_soon_as_possible)
    action_server(spun)
    watch.close()
    result = result_of(result_of(sent[0]).get_result_async())
    assert (result.status, list(result.result.sequence)) == (GoalStatus.SUCCEEDED, [3])


def test_an_action_server_that_cannot_be_declared_whole_leaves_nothing(
    node: NodeCore, monkeypatch: pytest.MonkeyPatch
) -> None:
    declare = type(node.port).service

    def refuse_to_cancel(port: NodePort, endpoint: Endpoint, deliver: Any) -> Any:
        if 'cancel' in endpoint.name:
            raise TransportError('the wire refuses')
        return declare(port, endpoint, deliver)

    monkeypatch.setattr(type(node.port), 'service', refuse_to_cancel)
    before = node.graph.topic_names_and_types(), node.graph.service_names_and_types()
    with pytest.raises(TransportError):
        action_server(node)
    assert (node.graph.topic_names_and_types(), node.graph.service_names_and_types()) == before


def test_an_action_client_that_cannot_be_declared_whole_leaves_nothing(
    node: NodeCore, monkeypatch: pytest.MonkeyPatch
) -> None:
    declare = type(node.port).subscription

    def refuse_statuses(port: NodePort, endpoint: Endpoint, deliver: Any) -> Any:
        if 'status' in endpoint.name:
            raise TransportError('the wire refuses')
        return declare(port, endpoint, deliver)

    monkeypatch.setattr(type(node.port), 'subscription', refuse_statuses)
    with pytest.raises(TransportError):
        action_client(node)
    names = [f'/fib/_action/{name}' for name in ('send_goal', 'get_result', 'cancel_goal')]
    assert [node.graph.count(EndpointKind.CLIENT, name) for name in names] == [0, 0, 0]
    assert node.graph.count(EndpointKind.SUBSCRIPTION, '/fib/_action/feedback') == 0


def test_an_effect_that_fails_holds_up_no_other(
    spun: NodeCore, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    server, client = action_server(spun), action_client(spun)
    publish = server._endpoints.status.publish

    def fail_once(payload: bytes) -> None:
        monkeypatch.setattr(server._endpoints.status, 'publish', publish)
        raise TransportError('the wire is full')

    monkeypatch.setattr(server._endpoints.status, 'publish', fail_once)
    handle = result_of(client.send(Fibonacci.Goal(order=3)))
    assert result_of(handle.get_result_async()).status == GoalStatus.SUCCEEDED
    assert "Action 'fib': PublishStatus did not reach a client: the wire is full" in capfd.readouterr().err


class SlowReply(ClientPort):
    """Its reply is on its way, on another thread, while `request` returns."""

    def __init__(self) -> None:
        self.arriving = threading.Event()
        self.go_on = threading.Event()
        self.thread: threading.Thread

    def request(self, payload: bytes, on_reply: Any, on_end: Any, timeout_ns: int | None = None) -> int:
        sample = Sample(TRIGGER.encode_response(Trigger.Response()), 1, 0, 0, bytes(16))
        self.thread = threading.Thread(target=on_reply, args=(sample,))
        self.thread.start()
        assert self.arriving.wait(PATIENCE)
        return 1

    def cancel(self, sequence: int) -> None:
        return

    def close(self) -> None:
        self.go_on.set()


def test_a_reply_that_overtakes_its_sequence_number_is_not_reported_as_missing(
    node: NodeCore, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = ClientCore(node, TRIGGER, 'go', SERVICES_DEFAULT)
    port = SlowReply()

    class Pending(dict[int, Any]):
        def pop(self, *args: Any) -> Any:
            if threading.current_thread() is port.thread:
                port.arriving.set()  # the reply has found nothing here, and stops before it completes
                assert port.go_on.wait(PATIENCE)
                return None
            return super().pop(*args)

    client.pending = Pending()
    client._port, declared = port, client._port
    assert declared is not None
    declared.close()
    future = client.call_async(Trigger.Request())
    port.go_on.set()
    assert future.wait(STEADY.now() + 10**10)
    port.thread.join(PATIENCE)
    assert client.unanswered == 0
    assert client.pending == {}


def test_feedback_that_comes_while_its_goal_is_put_away_is_not_lost(spun: NodeCore) -> None:
    client = action_client(spun)
    heard: Collector[Any] = Collector()
    goal_id = bytes(range(16))
    feedback = FIBONACCI.feedback.encode(Fibonacci.Impl.FeedbackMessage())
    sample = Sample(wire.wrap(goal_id, feedback[:4] + feedback[20:]), 1, 0, 0, bytes(16))

    class Goals(dict[bytes, Any]):
        def pop(self, *args: Any) -> Any:
            found = super().pop(*args)
            client.streams._deliver_feedback(ref(client.streams), sample)
            return found

        def __delitem__(self, key: bytes) -> None:
            super().__delitem__(key)
            client.streams._deliver_feedback(ref(client.streams), sample)

    client.goals.active = Goals()
    action_server(spun, ActionCallbacks(execute, CALLBACKS.goal, lambda _: None, CALLBACKS.cancel))
    uuid = Fibonacci.Impl.FeedbackMessage().goal_id
    uuid.uuid[:] = list(goal_id)
    assert result_of(client.send(Fibonacci.Goal(), heard, uuid)).accepted
    client.goals._put_away(client.goals.active[goal_id])
    assert len(heard.expect(1)) == 1


def test_a_result_is_asked_for_again_after_the_wire_has_refused(
    spun: NodeCore, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = action_client(spun)
    action_server(spun)
    handle = result_of(client.send(Fibonacci.Goal(order=3)))
    with monkeypatch.context() as broken:
        broken.setattr(client.result_requests._port, 'request', refuse)
        with pytest.raises(TransportError):
            _ = handle.get_result_async()
    assert result_of(handle.get_result_async()).status == GoalStatus.SUCCEEDED


def refuse(*_: object) -> int:
    raise TransportError('the wire refuses')


def test_a_request_that_finds_its_service_closing_is_given_up_without_a_word(
    node: NodeCore, capfd: pytest.CaptureFixture[str]
) -> None:
    answered: Collector[Request] = Collector()
    service = ServiceCore(
        node, TRIGGER, 'go', lambda request, _: answered(request), SERVICES_DEFAULT, ReentrantCallbackGroup()
    )
    server = service._server
    client = ClientCore(node, TRIGGER, 'go', SERVICES_DEFAULT)
    _ = client.call_async(Trigger.Request())
    late = server.event_queue.take()
    assert late is not None
    service.destroy()
    server.event_queue.deliver(late)
    server._handle(late)
    assert server.refused == 0
    assert answered.items == []
    assert client.unanswered == 1
    assert 'requests wait already' not in capfd.readouterr().err
