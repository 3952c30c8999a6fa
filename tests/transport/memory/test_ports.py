"""The promises of the memory transport about topics and services, beyond the contract."""

from __future__ import annotations

import threading
from collections import defaultdict
from collections.abc import Callable

import pytest
from helpers.patience import soon
from helpers.wire import Answers, Side

from goalwire.errors import LocalError
from goalwire.logging import LogRecord
from goalwire.rules.qos import DurabilityPolicy, QoS
from goalwire.transport.contract import Request, Sample

Sides = tuple[Side, Side]


def sequences_into(event_queue: list[int]) -> Callable[[Sample], None]:
    return lambda sample: event_queue.append(sample.sequence)


def test_one_publisher_shared_by_many_threads_is_heard_in_order_by_everyone(sides: Sides) -> None:
    alpha, beta = sides
    event_queues: list[list[int]] = [[] for _ in range(3)]
    for event_queue in event_queues:
        beta.subscription('/chatter', sequences_into(event_queue))
    publisher = alpha.publisher('/chatter')

    def pour() -> None:
        for _ in range(500):
            publisher.publish(b'')

    threads = [threading.Thread(target=pour) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert event_queues == [list(range(1, 4001))] * 3


def test_publish_returns_after_the_delivery_even_if_another_thread_delivers(sides: Sides) -> None:
    alpha, beta = sides
    held_up, go_on = threading.Event(), threading.Event()
    seen: list[bytes] = []

    def deliver(sample: Sample) -> None:
        if not seen:
            held_up.set()
            assert soon(go_on)
        seen.append(bytes(sample.payload))

    beta.subscription('/chatter', deliver)
    publisher = alpha.publisher('/chatter')

    def publish_second() -> None:
        publisher.publish(b'second')
        seen.append(b'second was published')

    first = threading.Thread(target=publisher.publish, args=(b'first',))
    first.start()
    assert soon(held_up)
    second = threading.Thread(target=publish_second)
    second.start()
    second.join(0.05)  # a publish that waited for nobody would return now
    go_on.set()
    first.join()
    second.join()
    assert seen == [b'first', b'second', b'second was published']


def test_late_subscriptions_join_a_running_stream_without_gap_or_repetition(sides: Sides) -> None:
    alpha, beta = sides
    depth = 50
    qos = QoS(depth=depth, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = alpha.publisher('/map', qos)
    seen: dict[int, list[int]] = defaultdict(list)

    def pour() -> None:
        for _ in range(1000):
            publisher.publish(b'')

    threads = [threading.Thread(target=pour) for _ in range(2)]
    for thread in threads:
        thread.start()
    for number in range(20):
        beta.subscription('/map', sequences_into(seen[number]), qos)
    for thread in threads:
        thread.join()
    for sequences in seen.values():
        assert sequences == list(range(sequences[0], 2001))


def test_history_is_received_when_it_is_delivered(sides: Sides) -> None:
    alpha, beta = sides
    qos = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    alpha.publisher('/map', qos).publish(b'')
    samples: list[Sample] = []
    beta.subscription('/map', samples.append, qos)
    assert samples[0].received_timestamp > samples[0].source_timestamp


def test_a_receiver_that_raises_is_logged_and_spares_the_others(
    sides: Sides, records: list[LogRecord]
) -> None:
    alpha, beta = sides
    samples: list[Sample] = []

    def fail(_: Sample) -> None:
        raise ZeroDivisionError

    beta.subscription('/chatter', fail)
    beta.subscription('/chatter', samples.append)
    alpha.publisher('/chatter').publish(b'')
    assert len(samples) == 1
    assert "subscription '/chatter'" in records[-1].message
    assert 'ZeroDivisionError' in records[-1].message


def test_publishing_from_a_receiver_comes_after_not_within(sides: Sides) -> None:
    alpha, _ = sides
    publisher = alpha.publisher('/chatter')
    events: list[str] = []

    def receive(sample: Sample) -> None:
        events.append(f'begin {sample.sequence}')
        if sample.sequence == 1:
            publisher.publish(b'')
        events.append(f'end {sample.sequence}')

    alpha.subscription('/chatter', receive)
    publisher.publish(b'')
    assert events == ['begin 1', 'end 1', 'begin 2', 'end 2']


def test_a_payload_is_a_copy_where_its_buffer_could_change(sides: Sides) -> None:
    alpha, _ = sides
    samples: list[Sample] = []
    alpha.subscription('/chatter', samples.append)
    buffer = bytearray(b'before')
    alpha.publisher('/chatter').publish(buffer)  # type: ignore[arg-type]  # what callers do all the same
    buffer[:] = b'after!'
    assert samples[0].payload == b'before'


def test_a_request_is_answered_once(sides: Sides) -> None:
    alpha, beta = sides
    requests: list[Request] = []
    beta.service('/add', requests.append)
    answers = Answers()
    answers.ask(alpha.client('/add'))
    requests[0].reply(b'first')
    with pytest.raises(LocalError, match='/add'):
        requests[0].reply(b'second')
    answers.expect(replies=1)


def test_a_server_that_raises_is_logged_and_ends_the_request(sides: Sides, records: list[LogRecord]) -> None:
    alpha, beta = sides

    def fail(_: Request) -> None:
        raise ZeroDivisionError

    beta.service('/add', fail)
    answers = Answers()
    answers.ask(alpha.client('/add'))
    answers.expect(replies=0)
    assert "service '/add'" in records[-1].message


def test_a_client_callback_that_raises_harms_neither_the_server_nor_the_end(
    sides: Sides, records: list[LogRecord]
) -> None:
    alpha, beta = sides
    ends: list[int] = []

    def fail(_: object) -> None:
        raise ZeroDivisionError

    beta.service('/add', lambda request: request.reply(b''))
    alpha.client('/add').request(b'', fail, lambda _: ends.append(1))
    assert ends == [1]
    assert "client '/add'" in records[-1].message


def test_every_request_ends_once_whatever_closes_when(sides: Sides) -> None:
    alpha, beta = sides
    for _ in range(100):
        requests: list[Request] = []
        servers = [beta.service('/add', requests.append) for _ in range(2)]
        client = alpha.client('/add')
        answers = Answers()
        answers.ask(client)
        racers = [
            threading.Thread(target=servers[0].close),
            threading.Thread(target=client.close),
            *(threading.Thread(target=request.reply, args=(b'',)) for request in requests),
        ]
        for racer in racers:
            racer.start()
        for racer in racers:
            racer.join()
        servers[1].close()
        assert len(answers.replies_before_each_end) == 1
