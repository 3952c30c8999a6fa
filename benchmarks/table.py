"""The lines of the table, in its order."""

from __future__ import annotations

from benchmarks.lines import (
    action_feedback,
    action_goals,
    asyncio_calls,
    image,
    many_nodes,
    memory,
    service_blocking,
    service_in_flight,
    service_spin,
    startup,
    timer,
    topic_round_trip,
    topic_throughput,
)

LINES = [
    module.LINE
    for module in (
        service_spin, service_blocking, service_in_flight, topic_round_trip, topic_throughput, action_goals,
        action_feedback, timer, startup, memory, asyncio_calls, image, many_nodes,
    )
]  # fmt: skip
