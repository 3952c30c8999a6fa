"""Match messages of several topics by their time.

Each input has a queue: a dictionary of messages by stamp in ns. Callbacks run while the lock is not held.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from math import inf
from threading import Lock
from typing import Any

from rclpy.clock import ROSClock
from rclpy.duration import Duration

from message_filters.simple_filter import SimpleFilter
from message_filters.stamps import stamp_of, stamp_or_arrival

__all__ = ['ApproximateTimeSynchronizer', 'TimeSynchronizer']

Queue = dict[int, Any]


class TimeSynchronizer(SimpleFilter):
    """Calls back with one message from each input, all with the same stamp; each message is used once.

    Each input keeps the `queue_size` messages with the latest stamps until the other inputs have messages
    with these stamps.
    """

    def __init__(self, fs: Iterable[SimpleFilter], queue_size: int) -> None:
        super().__init__()
        self.queue_size = queue_size
        self.lock = Lock()
        self.connectInput(fs)

    def connectInput(self, fs: Iterable[SimpleFilter]) -> None:
        """Take the outputs of the filters `fs` as inputs, with empty queues."""
        filters = list(fs)
        self.queues: list[Queue] = [{} for _ in filters]
        self.input_connections = [
            input_.registerCallback(self.add, queue, index)
            for index, (input_, queue) in enumerate(zip(filters, self.queues, strict=True))
        ]

    def add(self, msg: Any, my_queue: Queue, my_queue_index: int | None = None) -> None:
        """Queue a message of the input `my_queue_index`; call back with each set that is complete."""
        stamp = stamp_of(msg).nanoseconds
        with self.lock:
            self._enqueue(msg, my_queue, stamp)
            complete = set(self.queues[0]).intersection(*self.queues[1:])
            sets = [self._take([common] * len(self.queues)) for common in sorted(complete)]
        for messages in sets:
            self.signalMessage(*messages)

    def _enqueue(self, msg: object, queue: Queue, stamp: int) -> None:
        queue[stamp] = msg
        while len(queue) > self.queue_size:
            del queue[min(queue)]

    def _take(self, stamps: Iterable[int]) -> list[object]:
        """Remove the messages with these stamps, one from each queue, and return them."""
        return [queue.pop(stamp) for queue, stamp in zip(self.queues, stamps, strict=True)]


class ApproximateTimeSynchronizer(TimeSynchronizer):
    """Calls back with one message from each input; their stamps are less than `slop` seconds apart.

    A new message is matched with the nearest messages of the other inputs. Messages without a header are
    dropped. With `allow_headerless` their time of arrival is used instead; with `sync_arrival_time` the time
    of arrival is used for all messages.
    """

    def __init__(
        self,
        fs: Iterable[SimpleFilter],
        queue_size: int,
        slop: float,
        allow_headerless: bool = False,
        sync_arrival_time: bool = False,
    ) -> None:
        self.slop = Duration(seconds=slop)
        self.allow_headerless = allow_headerless
        self.sync_arrival_time = sync_arrival_time
        super().__init__(fs, queue_size)

    def add(self, msg: Any, my_queue: Queue, my_queue_index: int | None = None) -> None:
        """Queue a message, and call back with the set of messages that it completes, if any."""
        if self.sync_arrival_time:
            stamp = ROSClock().now()
        else:
            known = stamp_or_arrival(
                msg, allow_headerless=self.allow_headerless, logger_name='message_filters_approx'
            )
            if known is None:
                return
            stamp = known
        with self.lock:
            self._enqueue(msg, my_queue, stamp.nanoseconds)
            stamps = self._match(stamp.nanoseconds, my_queue_index)
            messages = None if stamps is None else self._take(stamps)
        if messages is not None:
            self.signalMessage(*messages)

    def _match(self, stamp: int, index: int | None) -> tuple[int, ...] | None:
        """Return matching stamps, one from each queue, `stamp` from queue `index`; None without a match."""
        slop = self.slop.nanoseconds

        def near(queue: Queue) -> list[int]:
            return sorted((s for s in queue if abs(s - stamp) <= slop), key=lambda s: abs(s - stamp))

        candidates = [near(queue) for queue in self.queues]
        if index is None:
            return _first_within(candidates, slop, inf, -inf)
        if stamp not in self.queues[index]:  # the full queue has dropped this message, the oldest
            return None
        candidates[index] = [stamp]
        return _first_within(candidates, slop, stamp, stamp)


def _first_within(
    candidates: Sequence[Sequence[int]], slop: int, low: float, high: float
) -> tuple[int, ...] | None:
    """Return the first combination of one item from each sequence whose span is less than `slop`.

    The values `low` and `high` count as parts of every combination.

    Combinations are tried in the order of itertools.product. The cache remembers the partial combinations
    that failed, by their span, so that each is tried only once.
    """

    @cache
    def complete(level: int, low: float, high: float) -> tuple[int, ...] | None:
        if level == len(candidates):
            return ()
        for stamp in candidates[level]:
            lower, higher = min(low, stamp), max(high, stamp)
            if higher - lower < slop:
                rest = complete(level + 1, lower, higher)
                if rest is not None:
                    return (stamp, *rest)
        return None

    return complete(0, low, high) if all(candidates) else None
