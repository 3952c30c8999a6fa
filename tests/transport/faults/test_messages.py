"""Faults of messages: what arrives, in which order, and when."""

from __future__ import annotations

import pytest
from helpers.collector import Collector
from helpers.hand_clock import HandClock
from helpers.wire import BARE, Side

from goalwire.transport.contract import Sample, SessionOptions
from goalwire.transport.faults import (
    Delay,
    Duplication,
    Fault,
    Faults,
    FlippedBytes,
    Loss,
    Reordering,
    SlowReader,
)
from goalwire.transport.memory import TRANSPORT

from .conftest import Sides


def contents(samples: Collector[Sample]) -> list[int]:
    return [int(bytes(sample.payload)) for sample in samples.items]


def publish(sides: Sides, numbers: range, name: str = '/chatter') -> Collector[Sample]:
    """Publish numbers from alpha to beta; return the collector in which they arrive."""
    samples: Collector[Sample] = Collector()
    sides[1].subscription(name, samples)
    publisher = sides[0].publisher(name)
    for number in numbers:
        publisher.publish(b'%08d' % number)
    return samples


def test_without_a_fault_all_arrives_at_once(sides: Sides) -> None:
    assert contents(publish(sides, range(3))) == [0, 1, 2]


def fate_of_a_hundred(seed: int, other_topic: bool) -> list[int]:
    transport = Faults(Loss(rate=0.5), seed=seed).over(TRANSPORT)
    session = transport.open(SessionOptions(domain_id=232))
    try:
        side = Side(session, 'alpha', BARE)
        if other_topic:
            publish((side, side), range(10), '/other')
        return contents(publish((side, side), range(100)))
    finally:
        session.close()


def test_what_is_lost_depends_on_the_seed_and_on_nothing_else_that_is_sent() -> None:
    first = fate_of_a_hundred(seed=1, other_topic=False)
    assert 30 < len(first) < 70
    assert first == sorted(first)
    assert fate_of_a_hundred(seed=1, other_topic=True) == first
    assert fate_of_a_hundred(seed=2, other_topic=False) != first


@pytest.mark.parametrize(
    ('where', 'arrived'),
    [
        ({'name': '/chat*'}, []),
        ({'name': '/other'}, [0, 1, 2]),
        ({'source': 'alpha', 'target': '/beta'}, []),
        ({'source': 'beta'}, [0, 1, 2]),
        ({'times': 2}, [2]),
    ],
)
def test_a_fault_strikes_where_it_is_meant_to(
    sides: Sides, faults: Faults, where: dict[str, object], arrived: list[int]
) -> None:
    fault = faults.add(Loss(**where))  # type: ignore[arg-type]
    assert contents(publish(sides, range(3))) == arrived
    assert fault.struck == 3 - len(arrived)


def test_what_is_delayed_arrives_when_its_time_has_come_and_in_order(
    sides: Sides, faults: Faults, clock: HandClock
) -> None:
    fault = faults.add(Delay(0.5, jitter=0.5))
    samples = publish(sides, range(20))
    clock.advance(0.49)
    assert samples.items == []
    assert faults.under_way == 20
    faults.heal(fault)
    late = publish(sides, range(20, 21))  # another subscription on the same path: behind the first ones
    clock.advance(0.51)
    assert contents(samples) == list(range(len(samples.items)))
    samples.expect(21)
    assert contents(samples) == list(range(21))
    late.expect(1)
    assert samples.items[0].received_timestamp - samples.items[0].source_timestamp >= 500_000_000


def test_a_reordered_message_is_overtaken(sides: Sides, faults: Faults, clock: HandClock) -> None:
    faults.add(Reordering(by=0.1, times=1))
    samples = publish(sides, range(3))
    assert contents(samples) == [1, 2]
    clock.advance(0.1)
    samples.expect(3)
    assert contents(samples) == [1, 2, 0]


def test_a_duplicated_message_arrives_twice_in_a_row(sides: Sides, faults: Faults) -> None:
    faults.add(Duplication(times=1))
    samples = publish(sides, range(3))
    assert contents(samples) == [0, 0, 1, 2]
    assert [sample.sequence for sample in samples.items] == [1, 1, 2, 3]


def test_flipped_bytes_differ_behind_the_header(sides: Sides, faults: Faults) -> None:
    faults.add(FlippedBytes(number=2, times=5))
    arrived = [bytes(sample.payload) for sample in publish(sides, range(6)).items]
    assert len(arrived) == 6
    sent = [b'%08d' % number for number in range(6)]
    assert [payload[:4] for payload in arrived] == [b'0000'] * 6
    assert [payload == original for payload, original in zip(arrived, sent, strict=True)] == [False] * 5 + [
        True
    ]


def test_a_slow_reader_gets_one_message_a_period_and_loses_what_finds_no_room(
    sides: Sides, faults: Faults, clock: HandClock
) -> None:
    fault = faults.add(SlowReader(1.0, room=3))
    samples = publish(sides, range(10))
    assert contents(samples) == [0]
    for number in (2, 3, 4):
        clock.advance(1.0)
        samples.expect(number)
    assert contents(samples) == [0, 1, 2, 3]
    assert (fault.struck, fault.lost, faults.under_way) == (10, 6, 0)


def test_a_partition_lets_nothing_through_until_it_heals(sides: Sides, faults: Faults) -> None:
    partition = faults.partition('alpha', 'beta')
    assert publish(sides, range(3)).items == []
    assert partition.struck == 3
    faults.heal()
    assert contents(publish(sides, range(3))) == [0, 1, 2]


def test_a_one_way_partition_lets_the_other_way_through(sides: Sides, faults: Faults) -> None:
    faults.partition('beta', one_way=True)
    assert contents(publish(sides, range(3))) == [0, 1, 2]
    assert publish((sides[1], sides[0]), range(3)).items == []


def test_a_closed_subscription_gets_nothing_of_what_is_under_way(
    sides: Sides, faults: Faults, clock: HandClock
) -> None:
    faults.add(Delay(1.0))
    samples: Collector[Sample] = Collector()
    port = sides[1].subscription('/chatter', samples)
    sides[0].publisher('/chatter').publish(b'late')
    port.close()
    fence = publish(sides, range(1), '/fence')
    clock.advance(1.0)
    fence.expect(1)
    assert samples.items == []


@pytest.mark.parametrize(
    'make', [lambda: Loss(rate=1.5), lambda: Delay(-1.0), lambda: SlowReader(float('nan'))]
)
def test_a_fault_that_cannot_be_is_refused(make: type[Fault]) -> None:
    with pytest.raises(ValueError, match='got'):
        make()
