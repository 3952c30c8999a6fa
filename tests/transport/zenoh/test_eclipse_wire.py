"""Which queriers a client asks with."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
import zenoh
from helpers.collector import Collector

from goalwire.rules.time import S_TO_NS
from goalwire.transport.zenoh.eclipse_wire import Queriers

KEY = '0/lamp/std_srvs::srv::dds_::Trigger_/RIHS01_' + 'a1' * 32


@pytest.fixture
def queriers(peer: zenoh.Session) -> Iterator[Queriers]:
    made = Queriers(peer, KEY)
    yield made
    made.undeclare()


def declared(queriers: Queriers) -> list[int]:
    return sorted(queriers._declared)


@pytest.mark.parametrize(
    ('timeout_ns', 'seconds'),
    [(0, 1), (S_TO_NS - 1, 1), (S_TO_NS, 2), (5 * S_TO_NS, 8), (3600 * S_TO_NS, 4096), (2**62, 2**33)],
)
def test_a_time_is_rounded_up_to_a_power_of_two(queriers: Queriers, timeout_ns: int, seconds: int) -> None:
    queriers.get_within(timeout_ns)
    assert declared(queriers) == [0, seconds]
    assert seconds * S_TO_NS > timeout_ns


def test_similar_times_share_a_querier(queriers: Queriers) -> None:
    for timeout in (4.0, 5.0, 7.9):
        queriers.get_within(int(timeout * S_TO_NS))
    assert declared(queriers) == [0, 8]


def test_zenoh_gives_a_request_up_when_its_time_is_over(queriers: Queriers, peer: zenoh.Session) -> None:
    held: Collector[zenoh.Query] = Collector()
    handler = zenoh.handlers.Callback(held, indirect=False)
    server = peer.declare_queryable(KEY, handler, complete=True)
    replies: Collector[zenoh.Reply] = Collector()
    begun = time.monotonic()
    queriers.get_within(S_TO_NS // 10)(handler=zenoh.handlers.Callback(replies, indirect=False), payload=b'?')
    (reply,) = replies.expect()
    assert time.monotonic() - begun > 0.9
    assert reply.err is not None
    assert reply.err.payload.to_bytes() == b'Timeout'
    server.undeclare()  # type: ignore[no-untyped-call]


def test_nothing_is_sent_once_they_are_undeclared(queriers: Queriers) -> None:
    queriers.get_within(S_TO_NS)
    queriers.undeclare()
    assert declared(queriers) == []
    with pytest.raises(RuntimeError, match='undeclared'):
        queriers.get()
    with pytest.raises(RuntimeError, match='undeclared'):
        queriers.get_within(S_TO_NS)
