"""Sequence numbers, fragments, and the queue before the socket.

A link has eight priorities, and each has a reliable and a best-effort channel. That makes sixteen channels,
and each counts its own messages. All channels begin at the number in OPEN and count modulo 2^28, or less if
the other side wants smaller numbers. TCP loses no frame and keeps the order. So a receiver accepts each
number that is ahead by less than half of all numbers, and drops the others. It does not ask again for frames
that the sender left out.

A message that fits no batch travels in pieces, each a FRAGMENT in a batch of its own. The pieces must follow
one another in their channel. If another frame comes between them, the message is lost, but the link stays.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from itertools import chain

from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.link_messages import FRAGMENT, FRAME
from goalwire.zenoh.protocol.primitives import (
    MANDATORY,
    MORE,
    NUMBER_FORM,
    ZenohProtocolError,
    encode_padded,
)

PRIORITIES = 8
CHANNELS = 2 * PRIORITIES
DATA_PRIORITY = 5
CONTROL_CHANNEL = 1
"""The channel of declarations: reliable, of the highest priority."""
DATA_CHANNEL = 2 * DATA_PRIORITY + 1

IS_RELIABLE = 0x20
MORE_PIECES = 0x40
PRIORITY_EXTENSION = NUMBER_FORM | MANDATORY | 1
IS_FIRST = 0x02
IS_GIVEN_UP = 0x03

MASK = (1 << 28) - 1
"""The bits of a sequence number, unless the handshake agreed on fewer."""

HEAD_SIZE = 16
"""The most bytes that the length and the head of a frame or fragment take in a batch."""

Buffer = bytes | memoryview


def channel_of(priority: int, *, reliable: bool = True) -> int:
    """Return the channel of a priority."""
    return 2 * priority + reliable


def frame_head(channel: int, number: int) -> bytes:
    """Return the head of a frame. Most frames have the data priority; their heads do not name it."""
    reliable = IS_RELIABLE if channel & 1 else 0
    if channel >> 1 == DATA_PRIORITY:
        return bytes((FRAME | reliable,)) + encode_padded(number)
    priority = bytes((PRIORITY_EXTENSION, channel >> 1))
    return bytes((FRAME | reliable | MORE,)) + encode_padded(number) + priority


def fragment_head(channel: int, number: int, *, marks_first: bool, more: bool) -> bytes:
    """Return the head of a piece; `marks_first` marks the first one, if patch 1 was agreed."""
    header = FRAGMENT | (IS_RELIABLE if channel & 1 else 0) | (MORE_PIECES if more else 0)
    extensions = b''
    if channel >> 1 != DATA_PRIORITY:
        extensions = bytes((PRIORITY_EXTENSION | (MORE if marks_first else 0), channel >> 1))
    if marks_first:
        extensions += bytes((IS_FIRST,))
    return bytes((header | (MORE if extensions else 0),)) + encode_padded(number) + extensions


def pieces(message: Sequence[Buffer], size: int) -> Iterator[list[Buffer]]:
    """Cut a message, given in parts, into pieces of `size` bytes at most, without copying it."""
    piece: list[Buffer] = []
    room = size
    for part in message:
        view = memoryview(part)
        while len(view) > room:
            yield [*piece, view[:room]]
            view = view[room:]
            piece, room = [], size
        piece.append(view)
        room -= len(view)
    if piece:
        yield piece


class SentNumbers:
    """The next number of each channel of a link."""

    __slots__ = ('high', 'high_bytes', 'mask', 'next')

    def __init__(self, first: int, mask: int = MASK) -> None:
        """`mask` has all bits of a sequence number set."""
        self.next = [first] * CHANNELS
        self.mask = mask
        self.high, self.high_bytes = -1, b''
        """A number without its lowest seven bits, and the bytes of its encoding that have the other bits."""

    def take(self, channel: int) -> int:
        """Return a channel's next number, and count on."""
        number = self.next[channel]
        self.next[channel] = (number + 1) & self.mask
        return number

    def encode_high(self, number: int) -> bytes:
        """Return all bytes of a number's encoding but the first, and keep them: 128 numbers share them."""
        self.high_bytes = encoded = encode_padded(number)[1:]
        self.high = number >> 7  # last, since a signal's handler may raise before
        return encoded


class ReceivedNumbers:
    """The last number seen on each channel of a link."""

    __slots__ = ('_half', '_mask', 'last')

    def __init__(self, first: int, mask: int = MASK) -> None:
        """`mask` has all bits of a sequence number set."""
        self.last = [(first - 1) & mask] * CHANNELS
        self._mask = mask
        self._half = (mask + 1) // 2

    def advance(self, channel: int, number: int) -> int:
        """Accept `number` if it is ahead; return by how much, or 0 otherwise. Raises ZenohProtocolError."""
        if number > self._mask:
            raise ZenohProtocolError(f'sequence number {number} has more than {self._mask.bit_length()} bits')
        gap = (number - self.last[channel]) & self._mask
        # Numbers wrap around: a distance of half the range or more means that the number lies behind.
        if gap >= self._half:
            return 0
        self.last[channel] = number
        return gap


class PieceBudget:
    """Bytes that the unfinished messages of a link may take, and within `above` those of all links."""

    __slots__ = ('above', 'limit', 'used')

    def __init__(self, limit: int, above: PieceBudget | None = None) -> None:
        self.limit = limit
        self.above = above
        self.used = 0
        """Bytes of unfinished messages that are kept now."""


class Reassembly:
    """The pieces of one channel's message, up to MOST_PIECES and the bytes of its budget."""

    __slots__ = ('_budget', '_has_marks', '_pieces', '_quiet', 'is_refused', 'size')

    def __init__(self, *, has_marks: bool, budget: PieceBudget) -> None:
        """`has_marks` is True if the sender marks first pieces (patch 1)."""
        self._has_marks = has_marks
        self._budget = budget
        self._pieces: list[Buffer] | None = None
        self.size = 0
        """Bytes of the unfinished message that are kept."""
        self.is_refused = False
        """True if the budget had no room for the last piece."""
        self._quiet: tuple[int, float] | None = None
        """The number of pieces at the last `is_stale`, and since when that number is unchanged."""

    def add(self, piece: Buffer, *, gap: int, first: bool, more: bool, given_up: bool) -> bytes | None:
        """Add a piece; with the last one return the whole message.

        Raises ZenohProtocolError beyond the size limit.
        """
        self.is_refused = False
        # With patch 1, only a marked piece begins a message. Without it, any piece after a whole message
        # does.
        if first or (self._pieces is None and not self._has_marks):
            self.clear()
            self._pieces = []
        elif given_up or gap != 1:
            self.clear()
        # A piece was lost or given up: further pieces are ignored up to the next one that begins a message.
        if self._pieces is None:
            return None
        size = len(piece)
        self._pieces.append(piece)
        self.size += size
        budget = self._budget
        budget.used += size
        above = budget.above or budget
        if above is not budget:
            above.used += size
        # A message that is too large in itself breaks the protocol. If all unfinished messages together are
        # too large, only this message is lost.
        if self.size > budget.limit or len(self._pieces) > bounds.MOST_PIECES:
            self.clear()
            raise ZenohProtocolError(
                f'a message in pieces has more than {budget.limit} bytes or {bounds.MOST_PIECES} pieces'
            )
        if budget.used > budget.limit or above.used > above.limit:
            self.clear()
            self.is_refused = True
            return None
        if more:
            return None
        message = b''.join(self._pieces)
        self.clear()
        return message

    def clear(self) -> None:
        """Throw away the unfinished message."""
        budget = self._budget
        budget.used -= self.size
        if budget.above is not None:
            budget.above.used -= self.size
        self.size = 0
        self._pieces = self._quiet = None

    def is_stale(self, now: float) -> bool:
        """Throw the message away and return True if no piece has come for STALE_S. `now` in s."""
        if self._pieces is None:
            return False
        count = len(self._pieces)
        if self._quiet is None or self._quiet[0] != count:
            self._quiet = count, now
        elif now - self._quiet[1] >= bounds.STALE_S:
            self.clear()
            return True
        return False


_AT_ONCE = 1 << 18
"""Bytes that are handed to the socket at once. A more urgent message waits until they are written."""


class Frame:
    """A frame that waits. Messages of its channel join it until it is full or goes to the socket."""

    __slots__ = ('channel', 'parts', 'size')

    def __init__(self, channel: int, head: bytes, message: bytes) -> None:
        self.channel = channel
        self.parts = [b'', head, message]
        """The length, filled in when the frame is closed, the head, and the messages."""
        self.size = len(head) + len(message)


class SendQueue:
    """Batches that wait for a socket: the more urgent first, and first in first out within a priority.

    Small messages of one channel share a frame, as far as they fit. So 100 messages and more take one
    sequence number, one buffer and one write. A batch that the socket has begun to take is finished before
    any other.

    A signal's handler may raise between any two steps here. Each change is noted before it begins, so that
    `mend` can finish or undo it.
    """

    __slots__ = ('_begun', '_begun_size', '_moved', '_waiting', '_written', 'open', 'size', 'taken')

    def __init__(self) -> None:
        self.size = 0
        """Bytes that wait for the socket."""
        self._begun: deque[Buffer] = deque()
        self._begun_size = 0
        self._waiting: list[deque[Sequence[Buffer] | Frame]] = [deque() for _ in range(PRIORITIES)]
        self.open: list[Frame | None] = [None] * CHANNELS
        """For each channel, the frame that further messages may join."""
        self.taken = 0
        """Bytes of the last `next_buffers` that the socket took; the caller that writes them sets this."""
        self._moved: tuple[deque[Sequence[Buffer] | Frame], int, int] | None = None
        """Noted while a batch moves to `_begun`: its queue, the queue's length, the length of `_begun`."""
        self._written: tuple[list[Buffer], int] | None = None
        """Noted while buffers are written: these buffers, and the number of further buffers in `_begun`."""

    def __bool__(self) -> bool:
        return self.size > 0

    def add(self, priority: int, batch: Sequence[Buffer]) -> None:
        """Queue a batch, given as one or more buffers."""
        # No message may join an older frame of this priority from now on: it would overtake this batch.
        self.open[2 * priority] = self.open[2 * priority + 1] = None
        self._waiting[priority].append(batch)
        self.size += sum(map(len, batch))

    def begin(self, channel: int, head: bytes, message: bytes) -> None:
        """Queue a frame that other messages may join."""
        frame = self.open[channel] = Frame(channel, head, message)
        self._waiting[channel >> 1].append(frame)
        self.size += 2 + frame.size

    def add_rest(self, rest: Buffer) -> None:
        """Queue the rest of a batch that the socket took in part. The queue must be empty."""
        self._begun.append(rest)
        self._begun_size += len(rest)
        self.size += len(rest)

    def next_buffers(self, limit: int) -> list[Buffer]:
        """Return the buffers to write next, at most `limit` of them."""
        begun = self._begun
        # The queues are in the order of priority: urgent batches go before all batches that have not begun.
        for waiting in self._waiting:
            while waiting and len(begun) < limit and self._begun_size < _AT_ONCE:
                batch = waiting[0]
                if isinstance(batch, Frame):
                    batch = self._close(batch)
                self._moved = waiting, len(waiting), len(begun)
                begun.extend(batch)
                waiting.popleft()
                self._moved = None
                self._begun_size += sum(map(len, batch))
        buffers = [begun[at] for at in range(min(len(begun), limit))]
        self.taken = 0
        self._written = buffers, len(begun) - len(buffers)
        return buffers

    def _close(self, frame: Frame) -> Sequence[Buffer]:
        """Close a frame to further messages and return its batch."""
        if self.open[frame.channel] is frame:
            self.open[frame.channel] = None
        frame.parts[0] = frame.size.to_bytes(2, 'little')
        return (b''.join(frame.parts),)

    def note_written(self, size: int) -> None:
        """Remove the first `size` bytes of `next_buffers`: the socket has taken them."""
        self.size -= size
        self._begun_size -= size
        begun = self._begun
        while size:
            first = begun.popleft()
            if size < len(first):
                begun.appendleft(memoryview(first)[size:])
                break
            size -= len(first)
        self._written = None

    def mend(self) -> None:
        """Restore the tables after a signal's handler has raised in the midst of a change."""
        begun = self._begun
        if self._moved is not None:
            waiting, count, had_begun = self._moved
            # The batch is still in its queue, so its buffers are removed from `_begun` again.
            if len(waiting) == count:
                while len(begun) > had_begun:
                    begun.pop()
            self._moved = None
        if self._written is not None:
            # The socket took `taken` bytes of these buffers; only the rest remains to be sent.
            buffers, beyond = self._written
            rest = deque(_behind(buffers, self.taken))
            rest.extend(list(begun)[len(begun) - beyond :])
            self._begun = begun = rest
            self._written = None
        for frame in filter(None, self.open):
            frame.size = sum(map(len, frame.parts[1:]))
        self._begun_size = sum(map(len, begun))
        self.size = self._begun_size + sum(map(_size, chain.from_iterable(self._waiting)))

    def clear(self) -> None:
        """Empty the queues: the link has ended."""
        self.size = self._begun_size = 0
        self._moved = self._written = None
        self._begun.clear()
        self.open = [None] * CHANNELS
        for waiting in self._waiting:
            waiting.clear()


def _size(batch: Sequence[Buffer] | Frame) -> int:
    return 2 + batch.size if isinstance(batch, Frame) else sum(map(len, batch))


def _behind(buffers: list[Buffer], size: int) -> Iterator[Buffer]:
    """Yield some buffers without their first `size` bytes."""
    for each in buffers:
        if size < len(each):
            yield memoryview(each)[size:] if size else each
        size = max(0, size - len(each))
