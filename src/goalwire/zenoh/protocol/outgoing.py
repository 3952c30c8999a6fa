"""The sending half of a link: numbers messages, packs them into batches, and writes the batches.

`send` numbers a message, makes a batch of it and writes it at once. If the socket is full, the message waits
in the queue of its priority, in one frame with others. In a flood, small messages wait for a moment to share
a frame, although the socket has room. If more than QUEUE_LIMIT bytes wait already, a droppable message is
dropped and counted. A message that may not be dropped waits for room first, if its thread may wait, which the
session's owner decides.

Numbering, queueing and writing are done in one critical section. If a signal's handler sends while its own
thread is sending, the handler's message goes out right after the message of the thread.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Protocol

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.channels import (
    CONTROL_CHANNEL,
    DATA_CHANNEL,
    DATA_PRIORITY,
    HEAD_SIZE,
    PRIORITIES,
    Buffer,
    SendQueue,
    SentNumbers,
    fragment_head,
    frame_head,
    pieces,
)
from goalwire.zenoh.protocol.link_messages import KEEP_ALIVE_MESSAGE, MAX_BATCH, close_message
from goalwire.zenoh.protocol.primitives import FOLLOWED

if TYPE_CHECKING:
    from goalwire.zenoh.protocol.handshake import Terms
    from goalwire.zenoh.protocol.shared_memory import LinkMemory

QUEUE_LIMIT = 2 << 20
"""Bytes that may wait for a socket. Above this, droppable messages are dropped, and others wait for room."""
QUEUE_END = 1 << 30
"""Bytes that may wait in all, since some messages can neither be dropped nor wait. Above, the link is
closed."""
_AT_ONCE = 64
HELD_SIZE = 8192
"""Bytes that are held back at most. With a system call for 45 messages of 180 bytes, each costs 0.05 µs, not
1.7. The first of them waits for 0.1 ms."""


def join_small(messages: Sequence[bytes], room: int) -> Iterator[bytes]:
    """Join messages into groups of at most `room` bytes. A larger message is a group of its own."""
    together: list[bytes] = []
    size = 0
    for message in messages:
        if together and size + len(message) > room:
            yield b''.join(together)
            together, size = [], 0
        together.append(message)
        size += len(message)
    if together:
        yield b''.join(together)


class Connection(Protocol):
    """A connected socket, as far as a link needs it to send. `write` and `write_many` never block."""

    @property
    def can_hold(self) -> bool:
        """True if `hold` has held messages released soon; otherwise no message is held back."""

    def write(self, data: Buffer) -> int:
        """Write as much as the socket takes, and return how many bytes that is."""

    def write_many(self, buffers: list[Buffer]) -> int:
        """Write some buffers one after the other, as far as the socket takes them; return how many bytes."""

    def request_flush(self) -> None:
        """Have `Outgoing.flush` called once the socket has room again."""

    def wait_for_room(self, is_answer: bool) -> None:
        """Block until fewer bytes wait, if this thread may. An answer waits only while its reader reads."""

    def hold(self, outgoing: Outgoing) -> None:
        """Have `Outgoing.release` called soon."""


class Outgoing:
    """The sending half of one link; any thread may use it."""

    def __init__(self, connection: Connection) -> None:
        self.is_open = True
        self.section = CriticalSection(self._mend)
        self.lock = self.section.lock
        self._acquire, self._release = self.section.acquire, self.section.release
        self.spoke = True
        """True if a message was sent since the last `tick`."""
        self.dropped = 0
        """How many messages were dropped for lack of room."""
        self.memory: LinkMemory | None = None
        """The memory through which the other side gets large payloads; None if it gets bytes."""
        self.queue = SendQueue()
        self.overflowed = False
        """True if more than QUEUE_END bytes wait: then the link must be closed."""
        self._connection = connection
        self._write = connection.write
        self._can_hold = connection.can_hold
        self._is_agreed = False
        self.is_held = False
        """True while messages are held back to share a frame, although the socket has room."""
        self._numbers = SentNumbers(0)
        self.room = MAX_BATCH - HEAD_SIZE
        """Bytes of messages that fit into one frame."""
        self._marks_first = False
        self._has_priorities = True
        self._retired: list[bytes] = []

    def agree(self, terms: Terms) -> None:
        """Apply the terms of the handshake to everything that is sent from now on."""
        self._numbers = SentNumbers(terms.first_sent, terms.number_mask)
        self.room = terms.batch_size - HEAD_SIZE
        self._marks_first = terms.patch > 0
        self._has_priorities = terms.qos
        self._is_agreed = True

    def send(
        self,
        channel: int,
        message: bytes,
        droppable: bool = False,
        may_wait: bool = False,
        is_answer: bool = False,
    ) -> bool:
        """Send network messages in one frame, or in pieces; False if they were dropped or the link has ended.

        A message that is not droppable waits for room first, if its thread may wait. An answer waits only
        above UNREAD_LIMIT. A message that `may_wait` is held back for a moment, to go out with others.
        """
        queue = self.queue
        if queue.size > QUEUE_LIMIT and not self._finds_room(droppable, is_answer):
            return False
        size = len(message)
        if size > self.room:
            return self._send_pieces(channel, (message,))
        # hot path: `with` takes 0.25 µs more for a re-entrant lock (Python 3.11). The lock is taken inside
        # `try`, since a signal's handler may raise as soon as it is taken.
        section = self.section
        entered = False
        batch, taken = b'', 0
        try:
            self._acquire()
            if not self.is_open:
                return False
            if section.is_busy:  # a signal's handler has interrupted a send of its own thread
                section.late.append(partial(self._send_now, channel, message))
                return True
            if section.late:
                section.run_late()
            entered = section.is_busy = True
            self.spoke = True
            if queue.size or (may_wait and self._can_hold):
                frame = queue.open[channel]
                if frame is not None and may_wait and self.is_held and queue.size + size < HELD_SIZE:
                    frame.parts.append(message)  # hot path: in a flood, 44 of 45 messages end here
                    frame.size += size
                    queue.size += size
                    return True
                return self._send_together(channel, message, may_wait=may_wait)
            if channel == DATA_CHANNEL:
                # hot path: `_frame` is written out here, which saves four calls for each message
                numbers = self._numbers
                number = numbers.next[DATA_CHANNEL]
                numbers.next[DATA_CHANNEL] = (number + 1) & numbers.mask
                high = numbers.high_bytes if number >> 7 == numbers.high else numbers.encode_high(number)
                low = FOLLOWED[number & 0x7F]
                batch = b''.join(((size + 5).to_bytes(2, 'little'), b'%', low, high, message))
            else:
                batch = self._frame(channel, message)
            taken = self._write(batch)
            if taken != len(batch):
                queue.add_rest(memoryview(batch)[taken:])
                self._connection.request_flush()
            return True  # noqa: TRY300
        except BaseException:  # raised by a signal's handler
            if entered:
                self._mend(batch, taken)
            raise
        finally:
            try:
                if entered:
                    section.is_busy = False
                    if section.late:
                        section.run_late()
            finally:
                try:  # noqa: SIM105
                    self._release()
                except RuntimeError:  # a signal's handler raised while this thread waited for the lock
                    pass

    def _mend(self, batch: bytes = b'', taken: int = 0) -> None:
        """Queue `batch` without its first `taken` bytes: a signal's handler has raised in the section."""
        queue = self.queue
        queue.mend()
        if 0 < taken < len(batch) and not queue.size:
            queue.add_rest(memoryview(batch)[taken:])
        if queue.size:
            self.is_held = False
            self._connection.request_flush()

    def _send_together(self, channel: int, message: bytes, *, may_wait: bool) -> bool:
        """Queue a message in one frame with others. The caller holds the lock.

        The frame waits for the socket, or is held back (`is_held`): until HELD_SIZE bytes are held, or a
        message comes that may not wait, or `release` is called, as `Connection.hold` has asked for.
        """
        queue = self.queue
        is_first = not queue.size
        if is_first:
            self.is_held = True
        if not self._has_priorities:
            channel = 2 * DATA_PRIORITY | channel & 1
        size, frame = len(message), queue.open[channel]
        if frame is not None and frame.size + size <= self.room:
            frame.parts.append(message)
            frame.size += size
            queue.size += size
        else:
            queue.begin(channel, self._head(channel), message)
        if not self.is_held:
            self._check_bound()
        elif not may_wait or queue.size >= HELD_SIZE:
            self._send_held()
        elif is_first and self._can_hold:
            self._connection.hold(self)
        return True

    def release(self) -> None:
        """Send the messages that were held back. Any thread."""
        self.section.run(self._send_held)

    def _send_held(self) -> None:
        if self.is_held and not self._flush():
            self._connection.request_flush()

    def send_large(self, channel: int, message: Sequence[Buffer], *, droppable: bool) -> bool:
        """Send a message given in parts. The parts are not copied, and so must never change."""
        if self.queue.size > QUEUE_LIMIT and not self._finds_room(droppable):
            return False
        return self._send_pieces(channel, message)

    def _send_pieces(self, channel: int, message: Sequence[Buffer]) -> bool:
        if not self.is_open:
            return False
        self.section.run(partial(self._send_now, channel, *message))
        return True

    def wait_for_room(self) -> None:
        """Wait until a droppable message would not be dropped, if this thread may wait."""
        if self.queue.size > QUEUE_LIMIT:
            self._connection.wait_for_room(False)

    def _finds_room(self, droppable: bool, is_answer: bool = False) -> bool:
        """Wait for room, or drop the message and return False. Called if the queue is above its limit."""
        if droppable:
            self.dropped += 1
            return False
        if is_answer and self.queue.size <= bounds.UNREAD_LIMIT:
            return True
        if not self.section.is_entered():  # otherwise this call would wait for the thread that it interrupts
            self._connection.wait_for_room(is_answer)
        return True

    def _frame(self, channel: int, message: bytes) -> bytes:
        if not self._has_priorities:
            channel = 2 * DATA_PRIORITY | channel & 1
        head = self._head(channel)
        return (len(head) + len(message)).to_bytes(2, 'little') + head + message

    def _head(self, channel: int) -> bytes:
        """Return the head of a channel's next frame."""
        return frame_head(channel, self._numbers.take(channel))

    def _check_bound(self) -> None:
        """Have the link closed if its queue is above QUEUE_END."""
        if self.queue.size > QUEUE_END:
            self.overflowed = True
            self._connection.request_flush()

    def declare(self, *messages: bytes) -> None:
        """Send declarations in as few frames as possible, without waiting for room."""
        for together in join_small(messages, self.room):
            self.section.run(partial(self._send_now, CONTROL_CHANNEL, together))

    def _send_now(self, channel: int, *message: Buffer) -> None:
        """Send a message given in parts, in one frame or in pieces, after the held ones. In the section."""
        if not self.is_open:
            return
        if not self._has_priorities:
            channel = 2 * DATA_PRIORITY | channel & 1
        self.spoke = True
        is_free = self.is_held or not self.queue.size  # if False, a later `flush` sends the message
        if sum(map(len, message)) <= self.room:
            self.queue.add(channel >> 1, (self._frame(channel, b''.join(message)),))
        else:
            self._queue_pieces(channel, message)
        if is_free and not self._flush():
            self._connection.request_flush()
        self._check_bound()

    def _queue_pieces(self, channel: int, message: Sequence[Buffer]) -> None:
        left = sum(map(len, message))
        marks_first = self._marks_first
        numbers = self._numbers
        number = numbers.next[channel]
        try:
            for piece in pieces(message, self.room):
                size = sum(map(len, piece))
                left -= size
                number = numbers.take(channel)
                head = fragment_head(channel, number, marks_first=marks_first, more=left > 0)
                marks_first = False
                self.queue.add(channel >> 1, ((len(head) + size).to_bytes(2, 'little') + head, *piece))
        # A signal's handler has raised. A gap in the numbers tells the reader to drop the begun message.
        except BaseException:
            numbers.next[channel] = (number + 2) & numbers.mask
            raise

    def send_transport(self, message: bytes, priority: int = 0) -> None:
        """Send a message of the link itself, as a batch of its own."""
        self.section.run(partial(self._send_batch, priority, len(message).to_bytes(2, 'little') + message))

    def _send_batch(self, priority: int, batch: bytes) -> None:
        self.spoke = True
        is_free = self.is_held or not self.queue.size
        self.queue.add(priority, (batch,))
        if is_free and not self._flush():
            self._connection.request_flush()

    def flush(self) -> bool:
        """Write the queued bytes; return False if the socket is full again."""
        self.section.run(self._flush)
        return not self.queue.size

    def _flush(self) -> bool:
        queue = self.queue
        self.is_held = False
        while queue.size:
            # one bytecode stores the result: a signal's handler may raise only after it
            queue.taken = self._connection.write_many(queue.next_buffers(_AT_ONCE))
            is_full = not queue.taken
            queue.note_written(queue.taken)
            if is_full:
                return False
        if self._retired:
            retired, self._retired = self._retired, []
            self.declare(*retired)
        return not queue.size

    def retire_expression(self, message: bytes) -> None:
        """Send the undeclaration of a key's number after all queued messages, which may use the number."""
        self.section.run(partial(self._retire, message))

    def _retire(self, message: bytes) -> None:
        if self.queue.size:
            self._retired.append(message)
        else:
            self._send_now(CONTROL_CHANNEL, message)

    def tick(self) -> None:
        """Send KEEP_ALIVE if nothing was sent since the last call, a quarter of this side's lease ago."""
        if self._is_agreed and not self.spoke and not self.queue.size:
            self.send_transport(KEEP_ALIVE_MESSAGE)
        self.spoke = False

    def close(self, reason: int | None = None) -> None:
        """Stop sending; with a `reason`, send CLOSE first."""
        with self.lock:
            if not self.is_open:
                return
            if reason is not None:
                self.send_transport(close_message(reason), PRIORITIES - 1)
            self.is_open = self._is_agreed = False
