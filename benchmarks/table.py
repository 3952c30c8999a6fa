"""The lines of the table, in its order."""

from __future__ import annotations

from benchmarks.lines import (
    action_feedback,
    action_first_goal,
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
    service_spin.LINE,
    service_spin.PINNED,
    service_blocking.LINE,
    service_in_flight.LINE,
    topic_round_trip.LINE,
    topic_round_trip.PINNED,
    topic_throughput.LINE,
    action_goals.LINE,
    action_feedback.LINE,
    action_first_goal.LINE,
    timer.LINE,
    startup.LINE,
    memory.LINE,
    asyncio_calls.LINE,
    image.LINE,
    many_nodes.LINE,
]
