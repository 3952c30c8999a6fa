"""Actions and what the wire may bring: rejected, logged, and everything goes on."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import result_of

from goalwire.entities.actions.client import ActionClientCore
from goalwire.entities.actions.server import ActionServerCore
from goalwire.entities.actions.server_goal_handle import (
    ActionCallbacks,
    CancelResponse,
    GoalResponse,
    ServerGoalHandle,
)
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import ServiceSupport, action_support
from goalwire.errors import DecodeError
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.logging import LogRecord
from goalwire.rules.goals import wire
from goalwire.rules.qos import ACTION_STATUS_DEFAULT, DEFAULT, SERVICES_DEFAULT
from goalwire.transport.contract import Endpoint, EndpointKind, Request, Sample

SUPPORT = action_support(Fibonacci)
BAD = [b'', b'\x00\x01\x00\x00', b'\x00\x01\x00\x00' + bytes(15), b'\x00\x07\x00\x00' + bytes(3)]


@pytest.fixture
def node(spun: NodeCore) -> NodeCore:
    """These tests want their node spun."""
    return spun


def execute(handle: ServerGoalHandle) -> Fibonacci.Result:
    handle.succeed()
    return Fibonacci.Result(sequence=[handle.request.order])


@pytest.fixture
def server(node: NodeCore) -> ActionServerCore:
    callbacks = ActionCallbacks(
        execute,
        goal=lambda _: GoalResponse.ACCEPT,
        accepted=ServerGoalHandle.execute,
        cancel=lambda _: CancelResponse.ACCEPT,
    )
    return ActionServerCore(node, SUPPORT, 'fib', callbacks, ReentrantCallbackGroup())


@pytest.fixture
def client(node: NodeCore) -> ActionClientCore:
    return ActionClientCore(node, SUPPORT, 'fib', ReentrantCallbackGroup())


def run_a_goal(client: ActionClientCore) -> list[int]:
    handle = result_of(client.send(Fibonacci.Goal(order=3)))
    return list(result_of(handle.get_result_async()).result.sequence)


@pytest.mark.parametrize('payload', BAD, ids=len)
@pytest.mark.parametrize(
    ('part', 'support'),
    [
        ('send_goal', SUPPORT.send_goal),
        ('get_result', SUPPORT.get_result),
        ('cancel_goal', SUPPORT.cancel_goal),
    ],
    ids=['send_goal', 'get_result', 'cancel_goal'],
)
def test_a_server_gives_up_requests_that_are_none(
    node: NodeCore,
    server: ActionServerCore,
    client: ActionClientCore,
    part: str,
    support: ServiceSupport,
    payload: bytes,
) -> None:
    endpoint = Endpoint(
        EndpointKind.CLIENT, f'/fib/_action/{part}', support.type_name, support.type_hash, SERVICES_DEFAULT
    )
    port, ended = node.port.client(endpoint), threading.Event()
    port.request(payload, lambda _: pytest.fail('answered'), lambda _: ended.set())
    assert ended.wait(PATIENCE)
    assert sum(part.rejected for part in server._endpoints.servers) == 1
    assert run_a_goal(client) == [3]
    port.close()


def test_a_server_gives_up_a_goal_whose_fields_are_cut_off(
    node: NodeCore, server: ActionServerCore, client: ActionClientCore
) -> None:
    support = SUPPORT.send_goal
    endpoint = Endpoint(
        EndpointKind.CLIENT, '/fib/_action/send_goal', support.type_name, support.type_hash, SERVICES_DEFAULT
    )
    port, ended = node.port.client(endpoint), threading.Event()
    port.request(wire.wrap(b'\x01' * 16, b'\x00\x01\x00\x00\x05\x00'), lambda _: None, lambda _: ended.set())
    assert ended.wait(PATIENCE)
    assert server.reactor.statistics().deciding == 0
    assert run_a_goal(client) == [3]
    port.close()


@pytest.mark.parametrize('payload', [*BAD, b'\x00\x01\x00\x00' + b'\xff' * 60], ids=len)
def test_a_client_rejects_statuses_and_feedback_that_are_none(
    node: NodeCore, server: ActionServerCore, client: ActionClientCore, payload: bytes
) -> None:
    heard: Collector[Any] = Collector()
    for part, support, qos in (
        ('status', SUPPORT.status, ACTION_STATUS_DEFAULT),
        ('feedback', SUPPORT.feedback, DEFAULT),
    ):
        endpoint = Endpoint(
            EndpointKind.PUBLISHER, f'/fib/_action/{part}', support.type_name, support.type_hash, qos
        )
        port = node.port.publisher(endpoint)
        port.publish(payload)
        port.close()
    handle = result_of(client.send(Fibonacci.Goal(order=3), heard))
    assert list(result_of(handle.get_result_async()).result.sequence) == [3]
    assert heard.items == []


def test_feedback_that_cannot_be_decoded_never_reaches_its_callback(
    node: NodeCore, client: ActionClientCore, capfd: pytest.CaptureFixture[str]
) -> None:
    heard: Collector[Any] = Collector()
    requests: Collector[Request] = Collector()
    goal_service = Endpoint(
        EndpointKind.SERVICE,
        '/fib/_action/send_goal',
        SUPPORT.send_goal.type_name,
        SUPPORT.send_goal.type_hash,
        SERVICES_DEFAULT,
    )
    feedback = Endpoint(
        EndpointKind.PUBLISHER,
        '/fib/_action/feedback',
        SUPPORT.feedback.type_name,
        SUPPORT.feedback.type_hash,
        DEFAULT,
    )
    service, publisher = node.port.service(goal_service, requests), node.port.publisher(feedback)
    future = client.send(Fibonacci.Goal(), heard)
    (request,) = requests.expect()
    goal_id = wire.goal_id_of(request.sample.payload)
    publisher.publish(wire.wrap(goal_id, b'\x00\x01\x00\x00\xff\xff\xff\x7f'))
    publisher.publish(SUPPORT.feedback.encode(_feedback(goal_id)))
    request.reply(wire.encode_acceptance(True, 5))  # feedback that came before waits for it
    assert list(heard.expect()[0].feedback.sequence) == [8]
    assert len(heard.items) == 1
    assert 'a feedback message was rejected' in capfd.readouterr().err
    assert result_of(future).accepted
    assert client.statistics().rejected == 1
    service.close()
    publisher.close()


def _feedback(goal_id: bytes) -> Any:
    from unique_identifier_msgs.msg import UUID

    return Fibonacci.Impl.FeedbackMessage(
        goal_id=UUID(uuid=list(goal_id)), feedback=Fibonacci.Feedback(sequence=[8])
    )


@pytest.mark.parametrize('payload', [b'', b'\x00\x01\x00\x00\x01'], ids=len)
def test_an_answer_that_is_none_raises_where_it_is_asked_for(
    node: NodeCore, client: ActionClientCore, payload: bytes
) -> None:
    requests: Collector[Request] = Collector()
    support = SUPPORT.send_goal
    endpoint = Endpoint(
        EndpointKind.SERVICE, '/fib/_action/send_goal', support.type_name, support.type_hash, SERVICES_DEFAULT
    )
    service = node.port.service(endpoint, requests)
    future = client.send(Fibonacci.Goal())
    requests.expect()[0].reply(payload)
    with pytest.raises(DecodeError, match='Fibonacci_SendGoal_Response'):
        result_of(future)
    service.close()


def test_rejected_feedback_and_statuses_are_told_at_powers_of_ten(
    client: ActionClientCore, records: list[LogRecord]
) -> None:
    queue = client.streams.make_feedback_queue(lambda _: None)
    sample = Sample(b'\x00\x01\x00\x00\xff', 1, 0, 0, bytes(16))
    for _ in range(150):
        queue.handle(sample)
        client.streams.statuses.handle(sample)
    told = [each.message.split(' (')[0].split(' by now')[0] for each in records]
    assert told == [
        f"Action 'fib': a {kind} message was rejected{times}"
        for times in ('', ', 10 times', ', 100 times')
        for kind in ('feedback', 'status')
    ]
    assert client.statistics().rejected == 300
    queue.close()
