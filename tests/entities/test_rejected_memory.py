"""Rejected data is gone at once: no exception holds it in a circle until the collector runs."""

from __future__ import annotations

import gc
import threading
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest
import rclpy
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import Spinner, wait_until
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from goalwire.entities.type_support import ServiceSupport, service_support
from goalwire.errors import CallError, DecodeError, EncodeError
from goalwire.execution.time.steady_clock import STEADY
from goalwire.rules.qos import SERVICES_DEFAULT
from goalwire.transport.contract import Endpoint, EndpointKind, Port

BIG = 8 << 20
BROKEN = b'\0\1\0\0\xff\xff\xff\x7f'
"""A string, or a sequence, of a length that no message has."""
NO_BOOL = b'\0\1\0\0\7\0\0\0'

Held = Callable[[], int]


@pytest.fixture
def held() -> Iterator[Held]:
    """A function that returns how many more bytes are held than at the beginning, with nobody collecting.

    Garbage from before stays meanwhile, and is not counted: to collect it here would take a second.
    """
    gc.disable()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    yield lambda: tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    gc.enable()


@pytest.fixture
def node(isolated: dict[str, str]) -> Iterator[Node]:
    with rclpy.init(), SingleThreadedExecutor() as executor:
        node = Node('victim')
        with Spinner(executor, node):
            yield node


def bytes_of(size: int, start: bytes) -> bytes:
    """Make such a payload anew: the caller holds it no longer than it needs it."""
    return start + bytes(size)


@pytest.mark.parametrize('view', [False, True])
def test_what_a_decoder_refused_is_held_neither_by_its_error_nor_by_a_circle(held: Held, view: bool) -> None:
    kept: list[DecodeError] = []

    def refuse() -> None:
        data = bytes_of(BIG, BROKEN)
        with pytest.raises(DecodeError) as caught:
            deserialize_message(memoryview(data) if view else data, String)
        error = caught.value
        del caught, data
        error.__traceback__ = None  # of the test's own frames
        kept.append(error)

    refuse()
    refuse()
    assert held() < BIG / 2


def test_what_an_encoder_refused_is_not_held_by_a_circle(held: Held) -> None:
    def refuse() -> None:
        with suppress(EncodeError):
            serialize_message(String(data='\udc80' + 'x' * BIG))

    refuse()
    refuse()
    assert held() < BIG / 2


@pytest.mark.also_on_dds
def test_messages_that_are_none(node: Node, held: Held) -> None:
    came: Collector[String] = Collector()
    subscription = node.create_subscription(String, 'chatter', came, 10)
    publisher = node.create_publisher(String, 'chatter', 10)
    wait_until(node.context, lambda: publisher.get_subscription_count() == 1)
    for number in range(3):
        publisher.publish(bytes_of(BIG, BROKEN))
        publisher.publish(String(data=str(number)))
        came.expect(number + 1)
    assert subscription.rejected == 3
    assert held() < 1.5 * BIG


@pytest.mark.also_on_dds
def test_requests_that_are_none(node: Node, held: Held) -> None:
    service = node.create_service(SetBool, 'switch', lambda _, response: response)
    client = node.create_client(SetBool, 'switch')
    assert client.wait_for_service(10)
    port, ended = client._port, threading.Event()
    assert port is not None
    for _ in range(3):
        port.request(bytes_of(BIG, NO_BOOL), lambda _: None, lambda _: ended.set())
        assert ended.wait(20)
        ended.clear()
    assert service._server.rejected == 3
    assert held() < 1.5 * BIG


def _answer(node: Node, support: ServiceSupport, start: bytes) -> Port:
    end = Endpoint(EndpointKind.SERVICE, '/big', support.type_name, support.type_hash, SERVICES_DEFAULT)
    return node.handle.port.service(end, lambda request: request.reply(bytes_of(BIG, start)))


@pytest.mark.also_on_dds
@pytest.mark.parametrize('way', ['call', 'result', 'exception', 'retell'])
def test_replies_that_are_none(node: Node, held: Held, way: str) -> None:
    server = _answer(node, service_support(Trigger), b'\0\1\0\0\1\0\0\0\xff\xff\xff\x7f')
    client = node.create_client(Trigger, 'big')
    assert client.wait_for_service(10)
    if way == 'retell':
        client.call_timeout = 10.0

    def ask() -> None:
        if way in ('call', 'retell'):
            with suppress(DecodeError, CallError):
                client.call(Trigger.Request())
            return
        future = client.call_async(Trigger.Request())
        assert future.wait(STEADY.now() + int(PATIENCE * 1e9))
        if way == 'exception':
            assert isinstance(future.exception(), DecodeError)
        else:
            with suppress(DecodeError):
                future.result()

    for _ in range(3):
        ask()
    assert held() < 1.5 * BIG
    server.close()
