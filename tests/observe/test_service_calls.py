"""Calls of others, put together from their events."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from example_interfaces.srv import AddTwoInts
from service_msgs.msg import ServiceEventInfo

from goalwire.observe.service_calls import KEPT, ServiceCalls


def test_calls_are_put_together_from_their_events() -> None:
    events = ServiceCalls()

    def step(number: int, second: int, **contents: Any) -> None:
        info = ServiceEventInfo(
            event_type=number,
            stamp=Time(sec=second),
            client_gid=np.arange(16, dtype=np.uint8),
            sequence_number=7,
        )
        events.take(AddTwoInts.Event(info=info, **contents))

    step(0, 10, request=[AddTwoInts.Request(a=1, b=2)])
    step(1, 12)
    [call] = events.latest(9)
    assert (call.state, call.request, call.response, call.served_in) == (
        'request received',
        AddTwoInts.Request(a=1, b=2),
        None,
        None,
    )
    step(2, 15, response=[AddTwoInts.Response(sum=3)])
    step(3, 16)
    step(9, 99)
    assert (call.state, call.response, call.served_in, call.took) == (
        'response received',
        AddTwoInts.Response(sum=3),
        3.0,
        6.0,
    )
    for number in range(2 * KEPT):
        events.take(AddTwoInts.Event(info=ServiceEventInfo(sequence_number=number)))
    assert len(events.latest(9 * KEPT)) == KEPT


def test_steps_are_paired_by_client_and_number() -> None:
    calls = ServiceCalls()

    def step(kind: int, number: int, ms: int) -> None:
        info = ServiceEventInfo(event_type=kind, sequence_number=number)
        info.stamp.nanosec = ms * 1_000_000
        calls.take(AddTwoInts.Event(info=info))

    for event in ((0, 1, 0), (0, 2, 1), (1, 1, 2), (2, 1, 4), (3, 2, 6), (3, 1, 9), (3, 7, 9)):
        step(*event)  # of the last one the beginning was not seen
    shares = (0.5, 1.0)
    assert [calls.clients.percentile(share) for share in shares] == pytest.approx([0.005, 0.009])
    assert [calls.server.percentile(share) for share in shares] == pytest.approx([0.002, 0.002])
    assert (calls.clients.number, calls.server.number) == (2, 1)
