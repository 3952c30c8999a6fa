"""The frozen records that `statistics()` returns. Their counts begin at the creation of the entity.

This module is imported at the first call of `statistics()`. Durations are in seconds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.records import record

if TYPE_CHECKING:
    from goalwire.rules.goals.client import SentGoals
    from goalwire.rules.goals.goal_book import ServedGoals


@record
class LatencyHistogram:
    """Counts of durations by size. `counts[n]` counts durations of at least 2**(n-1) and less
    than 2**n ns.
    """

    counts: tuple[int, ...]

    def __repr__(self) -> str:
        return f'<{self.count} in LatencyHistogram, p50 {self.p50:.3g} s, p99 {self.p99:.3g} s>'

    @property
    def count(self) -> int:
        """The number of counted durations."""
        return sum(self.counts)

    def quantile(self, share: float) -> float:
        """Return the duration in s that a share of the durations did not exceed; 0 without durations.

        The duration is an estimate, since only the counts of buckets are known. Its error is less than a
        factor of 2. Raises ValueError for a share that is not from 0 to 1.
        """
        if not 0 <= share <= 1:
            raise ValueError(f'a share is from 0 to 1, not {share}')
        rank, below = share * self.count, 0
        for number, count in enumerate(self.counts):
            if count and below + count >= rank:
                shortest, longest = ((1 << number) >> 1), 1 << number
                return (shortest + (longest - shortest) * (rank - below) / count) / 1e9
            below += count
        return 0.0

    @property
    def p50(self) -> float:
        """The median, in s."""
        return self.quantile(0.5)

    @property
    def p99(self) -> float:
        """The 99th percentile of the durations, in s."""
        return self.quantile(0.99)


@record
class PublisherStatistics:
    """The counts of one publisher."""

    name: str
    published: int
    dropped: int = 0
    """The number of published messages that this end dropped, if the wire counts them. A message that two
    peers did not get may count twice."""


@record
class SubscriptionStatistics:
    """The counts of one subscription."""

    name: str
    taken: int
    """Messages handed to the callback, or to the iterator."""
    waiting: int
    dropped: int
    """Messages that found the queue full, or made it drop the oldest."""
    rejected: int
    """Messages that could not be decoded."""

    @property
    def received(self) -> int:
        """The number of all received messages or requests."""
        return self.taken + self.waiting + self.dropped + self.rejected


@record
class ClientStatistics:
    """The counts of one service client."""

    name: str
    sent: int
    """Requests that were sent. Each attempt of a retried call counts."""
    answered: int
    unanswered: int
    """Requests without an answer: there was no server, or it went away, or it gave them up."""
    in_flight: int
    latency: LatencyHistogram
    """The durations from a request to its response."""

    @property
    def given_up(self) -> int:
        """Requests whose caller stopped waiting, because of a deadline or a cancelled future."""
        return self.sent - self.answered - self.unanswered - self.in_flight


@record
class ServiceStatistics:
    """The counts of one service server."""

    name: str
    answered: int
    failed: int
    """Requests whose callback ended without an answer."""
    in_flight: int
    """Requests whose callback has not ended yet."""
    waiting: int
    refused: int
    """Requests that found the queue full."""
    rejected: int
    """Requests that could not be decoded."""
    latency: LatencyHistogram
    """The durations from the arrival of a request to its response."""

    @property
    def received(self) -> int:
        """The number of all received messages or requests."""
        return self.answered + self.failed + self.in_flight + self.waiting + self.refused + self.rejected


@record
class ActionClientStatistics:
    """The counts of one action client."""

    name: str
    goals: SentGoals
    feedback: int
    """Feedback messages for goals of this client."""
    feedback_dropped: int
    acceptance: LatencyHistogram
    """The durations from sending a goal to its acceptance or refusal."""
    duration: LatencyHistogram
    """The durations from sending a goal to its result."""
    rejected: int = 0
    """Feedback and status messages that could not be decoded."""


@record
class ActionServerStatistics:
    """The counts of one action server."""

    name: str
    goals: ServedGoals
    feedback: int
    """Feedback messages that were published."""
    failed: int
    """Goals whose execute callback raised an error."""
    waiting: int
    """Requests of all three services that wait for the executor."""
    refused: int
    """Requests that found the queue full."""
    rejected: int
    """Requests that could not be decoded."""
    execution: LatencyHistogram
    """The durations of the execute callback."""


@record
class TimerStatistics:
    """The counts of one timer."""

    period: float
    """The period in seconds."""
    calls: int
    missed: int
    """Periods without a call, because an earlier call was late."""
    lateness: LatencyHistogram
    """The delays of the calls after their due times."""


@record
class NodeStatistics:
    """The counts of all entities of a node, including its built-in services and /rosout."""

    name: str
    publishers: tuple[PublisherStatistics, ...]
    subscriptions: tuple[SubscriptionStatistics, ...]
    clients: tuple[ClientStatistics, ...]
    services: tuple[ServiceStatistics, ...]
    action_clients: tuple[ActionClientStatistics, ...]
    action_servers: tuple[ActionServerStatistics, ...]
    timers: tuple[TimerStatistics, ...]


NODE_KINDS = (
    PublisherStatistics,
    SubscriptionStatistics,
    ClientStatistics,
    ServiceStatistics,
    ActionClientStatistics,
    ActionServerStatistics,
    TimerStatistics,
)
"""In the order of NodeStatistics' fields."""
