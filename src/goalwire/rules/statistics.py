"""The records that `statistics()` returns: frozen, counted since the entity was made.

Imported when they are first asked for. Durations are in seconds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.records import record

if TYPE_CHECKING:
    from goalwire.rules.goals.client import SentGoals
    from goalwire.rules.goals.goal_book import ServedGoals


@record
class LatencyHistogram:
    """Counts of durations by size: `counts[n]` has those of at least 2**(n-1) and less than 2**n ns."""

    counts: tuple[int, ...]

    def __repr__(self) -> str:
        return f'<{self.count} in LatencyHistogram, p50 {self.p50:.3g} s, p99 {self.p99:.3g} s>'

    @property
    def count(self) -> int:
        """How many durations were counted."""
        return sum(self.counts)

    def quantile(self, share: float) -> float:
        """Return what that share of them did not exceed, in s, as far as the buckets tell; 0 for none.

        Within a bucket they are taken for evenly spread: the answer is off by less than a factor of 2.
        Raises ValueError for a share that is not from 0 to 1.
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
        """The time in s that 99 of 100 did not exceed."""
        return self.quantile(0.99)


@record
class PublisherStatistics:
    """The counts of one publisher."""

    name: str
    published: int
    dropped: int = 0
    """How many of the published messages this end dropped, as far as the wire tells; a message that two peers
    did not get may count twice."""


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
        """All messages or requests that came."""
        return self.taken + self.waiting + self.dropped + self.rejected


@record
class ClientStatistics:
    """The counts of one service client."""

    name: str
    sent: int
    """Requests, each attempt of a call that is retried."""
    answered: int
    unanswered: int
    """Requests that no server answered: there was none, it went away, or it gave them up."""
    in_flight: int
    latency: LatencyHistogram
    """From a request to its response."""

    @property
    def given_up(self) -> int:
        """Requests whose caller did not wait for the end: a deadline, or a cancelled future."""
        return self.sent - self.answered - self.unanswered - self.in_flight


@record
class ServiceStatistics:
    """The counts of one service server."""

    name: str
    answered: int
    failed: int
    """Requests that the callback gave up."""
    in_flight: int
    """Requests that the callback works on."""
    waiting: int
    refused: int
    """Requests that found the queue full."""
    rejected: int
    """Requests that could not be decoded."""
    latency: LatencyHistogram
    """From a request's arrival to its response."""

    @property
    def received(self) -> int:
        """All messages or requests that came."""
        return self.answered + self.failed + self.in_flight + self.waiting + self.refused + self.rejected


@record
class ActionClientStatistics:
    """The counts of one action client."""

    name: str
    goals: SentGoals
    feedback: int
    """Messages for goals of this client."""
    feedback_dropped: int
    acceptance: LatencyHistogram
    """From a goal to its acceptance or refusal."""
    duration: LatencyHistogram
    """From a goal to its result."""
    rejected: int = 0
    """Feedback and status messages that could not be decoded."""


@record
class ActionServerStatistics:
    """The counts of one action server."""

    name: str
    goals: ServedGoals
    feedback: int
    """Messages that were published."""
    failed: int
    """Goals whose execution raised."""
    waiting: int
    """Requests, of all three services, that wait for the executor."""
    refused: int
    """Requests that found the queue full."""
    rejected: int
    """Requests that could not be decoded."""
    execution: LatencyHistogram
    """From the beginning to the end of the execute callback."""


@record
class TimerStatistics:
    """The counts of one timer."""

    period: float
    """The period in seconds."""
    calls: int
    missed: int
    """Periods that went by without a call, since an earlier one was late."""
    lateness: LatencyHistogram
    """How late calls came."""


@record
class NodeStatistics:
    """The counts of everything that a node has, its built-in services and /rosout included."""

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
