"""A bounded queue of messages between the wire and the file; one thread writes them.

Threads of the wire put messages in and never wait. If the file is too slow and the queue is full, a new
message is dropped and counted. The writing thread also flushes the file from time to time, so a process that
is killed loses only the messages since the last flush.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable
from threading import Condition, Thread
from time import monotonic
from typing import NamedTuple, Protocol, TypeAlias

from goalwire.apps.bag.repeats import Repeats
from goalwire.errors import BagError
from goalwire.rosbag2.model import Message
from goalwire.transport.contract import Sample

FLUSH_S = 0.5
"""Seconds between writing and flushing; a killed process loses about this much at most."""
_BATCH_BYTES = 2**20


class Sink(Protocol):
    """The destination of messages: a bag, or a snapshot that is written to a bag on request."""

    def put(self, message: Message) -> None:
        """Take one message; raises BagError."""

    def flush(self) -> None:
        """Write all taken messages to the file; raises BagError."""

    def sync(self) -> None:
        """Force the written data to the disk. A thread other than the writing one calls this."""


_Work: TypeAlias = 'tuple[Message, bytes] | Callable[[], None]'
"""A message with its publisher's gid, or a job: both are handled in the order in which they came."""


class Losses(NamedTuple):
    """Messages that are missing in the file, by topic."""

    dropped: Counter[str]
    """Messages that arrived while the queue was full."""
    missed: Counter[str]
    """Messages that never arrived: the sequence numbers have gaps. Only Zenoh numbers messages."""


class Intake:
    """Takes messages from any thread, and hands them to a sink on a thread of its own."""

    def __init__(
        self, sink: Sink, limit: int, repeats: Repeats, *, failed: Callable[[BagError], object]
    ) -> None:
        """The queue holds up to `limit` bytes. The writing thread calls `failed` once if the sink raises."""
        self._sink = sink
        self._repeats = repeats
        self._limit = limit
        self._failed = failed
        self._condition = Condition()
        self._waiting: deque[_Work] = deque()
        self._held = 0
        self._is_closing = self._has_failed = False
        self._numbers: dict[bytes, tuple[int, int]] = {}
        """The first and the latest sequence number from each publisher, by its gid."""
        self.is_paused = False
        """While True, arriving messages are left out, and do not count as lost."""
        self.losses = Losses(Counter(), Counter())
        self.count = 0
        """The number of messages that have entered the queue."""
        self._counts: Counter[str] = Counter()
        self.byte_count = 0
        self._unsynced = Condition()
        self._is_unsynced = self._is_synced_at_end = False
        self._writer = Thread(target=self._write, name='bag-writer', daemon=True)
        self._syncer = Thread(target=self._sync, name='bag-sync', daemon=True)
        self._writer.start()
        self._syncer.start()

    # -- called on any thread --------------------------------------------------------------------------------

    def put(self, topic: str, sample: Sample, time: int) -> None:
        """Take one message that was received at `time`, in ns; drop it if the queue is full."""
        if self.is_paused:
            return
        payload, sequence, sent, _, gid = sample
        data = payload if isinstance(payload, bytes) else bytes(payload)
        with self._condition:
            if sequence:
                self._note_gap(topic, sequence, gid)
            if (self._held + len(data) > self._limit and self._held) or self._has_failed or self._is_closing:
                self.losses.dropped[topic] += not self._is_closing
                return
            self._waiting.append((Message(topic, time, data, sent, sequence), gid))
            self._held += len(data)
            self.count += 1
            self._counts[topic] += 1
            self.byte_count += len(data)
            if len(self._waiting) == 1:
                self._condition.notify()

    def counts(self) -> Counter[str]:
        """Return how many messages of each topic have entered the queue."""
        with self._condition:
            return self._counts.copy()

    def drop(self, topic: str) -> None:
        """Count a message that was dropped before it reached this queue, because another queue was full."""
        with self._condition:
            self.losses.dropped[topic] += not self._is_closing

    def _note_gap(self, topic: str, sequence: int, gid: bytes) -> None:
        """Count as missed the numbers between a publisher's latest message and this one.

        A message that arrives late is no longer counted as missed.
        """
        first, last = self._numbers.get(gid, (sequence, sequence - 1))
        if sequence > last:
            self.losses.missed[topic] += sequence - last - 1
            self._numbers[gid] = first, sequence
        elif first < sequence < last and self.losses.missed[topic]:
            self.losses.missed[topic] -= 1

    def run(self, job: Callable[[], None]) -> None:
        """Let the writing thread run `job` after the messages that have arrived so far."""
        with self._condition:
            self._waiting.append(job)
            self._condition.notify()

    def close(self) -> None:
        """Write the waiting messages, flush, and end the threads. Blocks. Idempotent."""
        with self._condition:
            self._is_closing = True
            self._condition.notify()
        self._writer.join()
        with self._unsynced:
            self._is_synced_at_end = True
            self._unsynced.notify()
        self._syncer.join()

    # -- run by the writing thread ---------------------------------------------------------------------------

    def _write(self) -> None:
        try:
            self._write_until_closed()
        except BagError as error:
            with self._condition:
                self._has_failed = True
                for work in self._waiting:
                    if isinstance(work, tuple):
                        self.losses.dropped[work[0].topic] += 1
                self._waiting.clear()
            self._failed(error)

    def _write_until_closed(self) -> None:
        due: float | None = None
        """The time of the next flush, by the monotonic clock; None if everything is flushed."""
        while True:
            with self._condition:
                while not (self._waiting or self._is_closing):
                    left = None if due is None else due - monotonic()
                    if left is not None and left <= 0:
                        break
                    self._condition.wait(left)
                batch, self._waiting = self._waiting, deque()
                is_last = self._is_closing
            if batch:
                try:
                    self._put_all(batch)
                except BagError:
                    with self._condition:
                        self._waiting.extendleft(reversed(batch))
                    raise
                due = due or monotonic() + FLUSH_S
            if due is not None and (is_last or monotonic() >= due):
                self._sink.flush()
                self._ask_for_sync()
                due = None
            if is_last:
                return

    def _put_all(self, batch: deque[_Work]) -> None:
        """Write messages and run jobs; room in the queue is freed after each _BATCH_BYTES."""
        written = 0
        while batch:
            work = batch[0]
            if isinstance(work, tuple):
                message, gid = work
                self._sink.put(message)
                self._repeats.note(message, gid)
                written += len(message.data)
            else:
                work()
            batch.popleft()
            if written >= _BATCH_BYTES or not batch:
                with self._condition:
                    self._held -= written
                written = 0

    # -- run by the thread that syncs the disk ---------------------------------------------------------------

    def _ask_for_sync(self) -> None:
        with self._unsynced:
            self._is_unsynced = True
            self._unsynced.notify()

    def _sync(self) -> None:
        """Force the flushed data to the disk, on its own thread, so that a slow disk delays nothing."""
        while True:
            with self._unsynced:
                self._unsynced.wait_for(lambda: self._is_unsynced or self._is_synced_at_end)
                if not self._is_unsynced:
                    return
                self._is_unsynced = False
            self._sink.sync()
