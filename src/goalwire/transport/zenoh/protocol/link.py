"""One link to another session: parses the bytes that come, and packs messages into batches.

`receive` takes bytes as they came, in any pieces. It runs the handshake, checks numbers, joins fragments, and
hands each network message to the session. `send` numbers a message, makes a batch of it and writes it at
once. If the socket is full, the message waits in the queue of its priority, in one frame with others. In a
flood, small messages wait for a moment to share a frame, although the socket has room. If more than
QUEUE_LIMIT bytes wait already, a message that may be dropped is dropped and counted. One that may not be
dropped waits for room first, if its thread may wait: the session's owner knows that. A link is dead when it
has heard nothing for the other side's lease. When it has sent nothing for a quarter of its own lease, it
sends KEEP_ALIVE.

All that numbers, queues or writes is done in one critical section: what a signal's handler sends while its
own thread is just sending goes out right after that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Protocol

from goalwire.errors import RemoteError
from goalwire.transport.critical_section import CriticalSection
from goalwire.transport.zenoh.protocol.channels import (
    CHANNELS,
    CONTROL_CHANNEL,
    DATA_CHANNEL,
    DATA_PRIORITY,
    HEAD_SIZE,
    IS_FIRST,
    IS_GIVEN_UP,
    IS_RELIABLE,
    MASK,
    MORE_PIECES,
    PRIORITIES,
    PRIORITY_EXTENSION,
    Buffer,
    Reassembly,
    ReceivedNumbers,
    SendQueue,
    fragment_head,
    frame_head,
    pieces,
)
from goalwire.transport.zenoh.protocol.declarations import (
    Declaration,
    Interest,
    read_declaration,
    read_interest,
)
from goalwire.transport.zenoh.protocol.forms import (
    KEY_SIZE,
    PushForm,
    ReplyForm,
    RequestForm,
    push_form,
    read_alike_query,
    read_alike_reply,
    reply_form,
    request_form,
)
from goalwire.transport.zenoh.protocol.handshake import Handshake, Terms
from goalwire.transport.zenoh.protocol.key_index import KeyIndex
from goalwire.transport.zenoh.protocol.link_state import LinkStates, Node
from goalwire.transport.zenoh.protocol.network import (
    DECLARE,
    INTEREST,
    IS_SENDERS,
    LARGE,
    OAM,
    PUSH,
    PUT_OF_ROS,
    QOS,
    REQUEST,
    RESPONSE,
    RESPONSE_FINAL,
    Sample,
    new_sample,
    read_body,
    read_extensions,
    read_query,
    read_reply,
    read_request_id,
    read_wire_key,
)
from goalwire.transport.zenoh.protocol.primitives import (
    EXPIRED,
    EXTENSION,
    MORE,
    PADDED_HIGH,
    PADDED_LOW,
    UNRESPONSIVE,
    Reader,
    ZenohProtocolError,
    decode_z,
    encode_padded,
)
from goalwire.transport.zenoh.protocol.transport import (
    CLOSE,
    FIRST_NETWORK_ID,
    FRAGMENT,
    FRAME,
    INIT,
    KEEP_ALIVE,
    KEEP_ALIVE_MESSAGE,
    MAX_BATCH,
    MESSAGE_ID,
    OPEN,
    Role,
    close_message,
)

if TYPE_CHECKING:
    from goalwire.transport.zenoh.protocol.network import QueryMessage, ReplyError

QUEUE_LIMIT = 2 << 20
"""Bytes that wait for a socket, beyond which a message that may be dropped is dropped, and others wait."""
QUEUE_END = 1 << 30
"""Bytes that may wait of what can neither be dropped nor wait; a link with more is given up."""
MESSAGE_LIMIT = 1 << 30
"""Bytes of one message in fragments, as Zenoh's own default."""
KEEP_ALIVES = 4
"""How many times within its lease a silent link says that it lives."""
MOST_KEPT = 5
"""How many times the size of a message in pieces may be kept until it is whole."""
ROUTES_LIMIT = 4096
"""Keys whose receivers one link remembers."""
_AT_ONCE = 64
HELD_SIZE = 8192
"""Bytes that are held back at most. A system call for 45 messages of 180 bytes costs each 0.05 µs, not 1.7;
the first of them waits for 0.1 ms."""

_PRIORITY = PRIORITY_EXTENSION & EXTENSION


LENGTH_SIZE = 2
"""Bytes before each batch that tell its length."""


def _missing(begun: bytes, most: int) -> int:
    """Return how many bytes a batch lacks that has begun; 0 where that is unknown, or more than `most`."""
    if len(begun) < LENGTH_SIZE:
        return 0
    missing = LENGTH_SIZE + (begun[0] | begun[1] << 8) - len(begun)
    return missing if missing <= most else 0


class ClosedByPeerError(RemoteError):
    """The other side said CLOSE: the link ends, and no program sees this."""


class Receivers(NamedTuple):
    """The receivers of what a link puts on one of its keys."""

    key: str
    callbacks: tuple[Callable[[Sample], None], ...]


class LinkOwner(Protocol):
    """A session, as far as a link needs it."""

    def link_is_up(self, link: Link) -> None:
        """The handshake is done."""

    def receivers(self, link: Link, scope: int, suffix: bytes, is_senders: int) -> Receivers:
        """Return the receivers of a key of this link's; remembered in `link.push_receivers`."""

    def callback_failed(self, error: Exception) -> None:
        """A user's function raised."""

    def query_came(
        self, link: Link, request: int, where: tuple[int, bytes, int], qos: int, query: QueryMessage
    ) -> None:
        """A REQUEST came for the key that `where` names: scope, suffix, whose."""

    def reply_key(self, link: Link, request: int, scope: int, suffix: bytes, is_senders: int) -> str | None:
        """Return the key that a RESPONSE names; None where nobody waits for it."""

    def reply_came(self, link: Link, request: int, answer: Sample | ReplyError) -> None:
        """A RESPONSE came."""

    def last_word(self, who: Link, request: int) -> None:
        """A RESPONSE_FINAL came."""

    def declaration_came(self, link: Link, declaration: Declaration) -> None:
        """A DECLARE came."""

    def interest_came(self, link: Link, interest: Interest) -> None:
        """An INTEREST came."""

    def nodes_came(self, link: Link, nodes: list[Node]) -> None:
        """An OAM told of nodes."""


class Link:
    """One link. `write` sends what it is given as far as the socket takes it, and returns how many bytes."""

    def __init__(
        self,
        owner: LinkOwner,
        handshake: Handshake,
        *,
        write: Callable[[Buffer], int],
        write_many: Callable[[list[Buffer]], int],
        when_full: Callable[[], None],
        wait_for_room: Callable[[], None],
        when_held: Callable[[Link], None] | None = None,
        lease_ms: int = 60_000,
    ) -> None:
        """`when_full` asks for a `flush` once the socket has room; `wait_for_room` blocks, where it may.

        `when_held` asks for a `release` soon; without it nothing is held back.
        """
        self.owner = owner
        self.handshake = handshake
        self.terms: Terms | None = None
        self.zid = b''
        self.role = Role.PEER
        self.is_open = True
        self.is_up = False
        self.section = CriticalSection(self._mend)
        self.lock = self.section.lock
        self._acquire, self._release = self.section.acquire, self.section.release
        # what the other side has
        self.expressions: dict[int, str] = {}
        self.expression_ids: dict[str, int] = {}
        self.subscribers: KeyIndex[None] = KeyIndex()
        self.queryables: KeyIndex[tuple[bool, int]] = KeyIndex()
        self.tokens: dict[int, str] = {}
        self.interests: dict[int, Interest] = {}
        self.told: set[int] = set()
        """Which of the session's expression ids the other side knows."""
        self.told_of: set[int] = set()
        """Which of the session's entities a client, which asks, was told of."""
        self.knows_all = False
        """Whether all that the other side has was told here; until then it gets everything."""
        self.link_states = LinkStates()
        # the receivers of each key, looked up once
        self.push_receivers: dict[object, Receivers] = {}
        self.push_forms: dict[bytes, PushForm] = {}
        self.request_forms: dict[bytes, RequestForm] = {}
        self.reply_forms: dict[bytes, ReplyForm] = {}
        # time
        self.keep_alive_s = lease_ms / 1000 / KEEP_ALIVES
        self.heard = True
        self.spoke = True
        self._silent_since: float | None = None
        # sending
        self.dropped = 0
        """Messages that found no room."""
        self.queue = SendQueue()
        self._write = write
        self._write_many = write_many
        self._when_full = when_full
        self._wait_for_room = wait_for_room
        self._when_held = when_held
        self.is_held = False
        """Whether what waits does so for others to join it, and not for the socket."""
        self._sent = [0] * CHANNELS
        self.room = MAX_BATCH - HEAD_SIZE
        """Bytes of messages that fit one frame."""
        self._marks_first = False
        self._has_priorities = True
        self._retired: list[bytes] = []
        # receiving
        self.reads = 0
        """Counts what `receive` has taken."""
        self.is_lost = False
        """Whether the session has let go of it."""
        self._largest_batch = MAX_BATCH
        self._tail = b''
        self._numbers = ReceivedNumbers(0)
        self._expected = b'none'
        self._reassembly: dict[int, Reassembly] = {}
        self.in_pieces = False
        """Whether of a message in pieces more are to come."""

    # ---- sending

    def start(self) -> None:
        """Say what a connector says first."""
        first = self.handshake.start()
        if first:
            self.send_transport(first)

    def send(self, channel: int, message: bytes, droppable: bool = False, may_wait: bool = False) -> bool:
        """Send network messages in one frame, or in pieces; False: dropped, or the link is gone.

        What is not droppable waits for room before, where its thread may. Where the link can hold messages
        back, one that `may_wait` does so, to go out together with those that follow.
        """
        queue = self.queue
        if queue.size > QUEUE_LIMIT and not self._finds_room(droppable=droppable):
            return False
        size = len(message)
        if size > self.room:
            return self._send_pieces(channel, (message,))
        # hot path: `with` takes 0.25 µs more for a lock that a thread may take twice (Python 3.11). The lock
        # is taken inside `try`, since a signal's handler may raise as soon as it is.
        section = self.section
        entered = False
        batch, taken = b'', 0
        try:
            self._acquire()
            if not self.is_open:
                return False
            if section.is_busy:
                section.late.append(partial(self._send_now, channel, message))
                return True
            if section.late:
                section.run_late()
            entered = section.is_busy = True
            self.spoke = True
            if queue.size or (may_wait and self._when_held):
                frame = queue.open[channel]
                if frame is not None and may_wait and self.is_held and queue.size + size < HELD_SIZE:
                    frame.parts.append(message)  # hot path: in a flood, 44 of 45 messages end here
                    frame.size += size
                    queue.size += size
                    return True
                return self._send_together(channel, message, may_wait=may_wait)
            if channel == DATA_CHANNEL:
                sent = self._sent
                number = sent[DATA_CHANNEL]
                sent[DATA_CHANNEL] = (number + 1) & MASK
                # hot path: encode_padded written out, one call less for each message.
                low, high = PADDED_LOW[number & 0x3FFF], PADDED_HIGH[number >> 14]
                batch = b''.join(((size + 5).to_bytes(2, 'little'), b'%', low, high, message))
            else:
                batch = self._frame(channel, message)
            taken = self._write(batch)
            if taken != len(batch):
                queue.add_rest(memoryview(batch)[taken:])
                self._when_full()
            return True  # noqa: TRY300
        except BaseException:  # of a signal's handler
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
                except RuntimeError:  # a signal's handler raised while this waited for the lock
                    pass

    def _mend(self, batch: bytes = b'', taken: int = 0) -> None:
        """Have what the socket took in part go on; a signal's handler has raised here, in the section.

        `taken` is how much of `batch` was.
        """
        queue = self.queue
        queue.mend()
        if 0 < taken < len(batch) and not queue.size:
            queue.add_rest(memoryview(batch)[taken:])
        if queue.size:
            self.is_held = False
            self._when_full()

    def _send_together(self, channel: int, message: bytes, *, may_wait: bool) -> bool:
        """Have a message wait, in one frame with others; under the lock.

        They wait since the socket is full, or because they may (`is_held`): then until HELD_SIZE bytes do, or
        something comes that may not wait, or whoever was told by `when_held` calls `release`.
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
            return self._is_bearable()
        if not may_wait or queue.size >= HELD_SIZE:
            self._send_held()
        elif is_first and self._when_held:
            self._when_held(self)
        return True

    def release(self) -> None:
        """Send what was held back. Any thread."""
        self.section.run(self._send_held)

    def _send_held(self) -> None:
        if self.is_held and not self._flush():
            self._when_full()

    def send_large(self, channel: int, message: Sequence[Buffer], *, droppable: bool) -> bool:
        """The same for a message in parts, which are not copied, and so must never change."""
        if self.queue.size > QUEUE_LIMIT and not self._finds_room(droppable=droppable):
            return False
        return self._send_pieces(channel, message)

    def _send_pieces(self, channel: int, message: Sequence[Buffer]) -> bool:
        if not self.is_open:
            return False
        self.section.run(partial(self._send_now, channel, *message))
        return True

    def wait_for_room(self) -> None:
        """Wait until what may be dropped is not, where this thread may wait."""
        if self.queue.size > QUEUE_LIMIT:
            self._wait_for_room()

    def _finds_room(self, *, droppable: bool) -> bool:
        """Where too much waits already: wait until it is less, or have the message dropped."""
        if droppable:
            self.dropped += 1
            return False
        if not self.section.is_entered():  # else it waits for the very thread that it interrupts
            self._wait_for_room()
        return True

    def _frame(self, channel: int, message: bytes) -> bytes:
        if not self._has_priorities:
            channel = 2 * DATA_PRIORITY | channel & 1
        head = self._head(channel)
        return (len(head) + len(message)).to_bytes(2, 'little') + head + message

    def _head(self, channel: int) -> bytes:
        """Return the head of a channel's next frame."""
        number = self._sent[channel]
        self._sent[channel] = (number + 1) & MASK
        return frame_head(channel, number)

    def _is_bearable(self) -> bool:
        """Whether the queue is within its last bound; if not, the owner gives the link up."""
        if self.queue.size > QUEUE_END:
            self.overflowed = True
            self._when_full()
        return True

    overflowed = False
    """Whether more waits than is borne."""

    def send_all(self, channel: int, messages: list[bytes]) -> None:
        """Send many small messages in as few frames as they fit, without waiting for room."""
        together: list[bytes] = []
        size = 0
        for message in messages:
            if together and size + len(message) > self.room:
                self.section.run(partial(self._send_now, channel, b''.join(together)))
                together, size = [], 0
            together.append(message)
            size += len(message)
        if together:
            self.section.run(partial(self._send_now, channel, b''.join(together)))

    def declare(self, *messages: bytes) -> None:
        """Send declarations, without waiting for room."""
        self.send_all(CONTROL_CHANNEL, list(messages))

    def _send_now(self, channel: int, *message: Buffer) -> None:
        """Send a message in parts, in one frame or in pieces, with all that was held back; in the section."""
        if not self.is_open:
            return
        if not self._has_priorities:
            channel = 2 * DATA_PRIORITY | channel & 1
        self.spoke = True
        is_free = self.is_held or not self.queue.size
        if sum(map(len, message)) <= self.room:
            self.queue.add(channel >> 1, (self._frame(channel, b''.join(message)),))
        else:
            self._queue_pieces(channel, message)
        if is_free and not self._flush():
            self._when_full()
        self._is_bearable()

    def _queue_pieces(self, channel: int, message: Sequence[Buffer]) -> None:
        left = sum(map(len, message))
        marks_first = self._marks_first
        sent = self._sent
        number = sent[channel]
        try:
            for piece in pieces(message, self.room):
                size = sum(map(len, piece))
                left -= size
                number = sent[channel]
                sent[channel] = (number + 1) & MASK
                head = fragment_head(channel, number, marks_first=marks_first, more=left > 0)
                marks_first = False
                self.queue.add(channel >> 1, ((len(head) + size).to_bytes(2, 'little') + head, *piece))
        except BaseException:  # of a signal's handler: no later piece may follow on the last one
            sent[channel] = (number + 2) & MASK
            raise

    def send_transport(self, message: bytes, priority: int = 0) -> None:
        """Send a message of the link itself, as a batch of its own."""
        self.section.run(partial(self._send_batch, priority, len(message).to_bytes(2, 'little') + message))

    def _send_batch(self, priority: int, batch: bytes) -> None:
        self.spoke = True
        is_free = self.is_held or not self.queue.size
        self.queue.add(priority, (batch,))
        if is_free and not self._flush():
            self._when_full()

    def flush(self) -> bool:
        """Write what waits; False where the socket is full again."""
        self.section.run(self._flush)
        return not self.queue.size

    def _flush(self) -> bool:
        queue = self.queue
        self.is_held = False
        while queue.size:
            # In one step: a signal's handler may raise before the next one.
            queue.taken = self._write_many(queue.next_buffers(_AT_ONCE))
            is_full = not queue.taken
            queue.written(queue.taken)
            if is_full:
                return False
        if self._retired:
            retired, self._retired = self._retired, []
            self.declare(*retired)
        return not queue.size

    def retire_expression(self, message: bytes) -> None:
        """Take an expression id back, once no message that names it waits any more."""
        self.section.run(partial(self._retire, message))

    def _retire(self, message: bytes) -> None:
        if self.queue.size:
            self._retired.append(message)
        else:
            self._send_now(CONTROL_CHANNEL, message)

    # ---- time

    def tick(self) -> None:
        """Called four times within the session's own lease: say that this side lives, if nothing else did."""
        if self.is_up and not self.spoke and not self.queue.size:
            self.send_transport(KEEP_ALIVE_MESSAGE)
        self.spoke = False

    def check_lease(self, now: float) -> None:
        """See whether the other side lives; `now` in s. Raises ZenohProtocolError where its lease is over."""
        if self.heard or self._silent_since is None:
            self.heard = False
            self._silent_since = now
        elif self.terms is not None and now - self._silent_since >= self.terms.lease_ms / 1000:
            raise ZenohProtocolError(
                f'nothing was heard for its lease of {self.terms.lease_ms / 1000:g} s', EXPIRED
            )
        if self.overflowed:
            raise ZenohProtocolError(f'more than {QUEUE_END >> 20} MiB wait to be sent', UNRESPONSIVE)

    def close(self, reason: int | None = None) -> None:
        """Send nothing any more; with a `reason`, say so first."""
        with self.lock:
            if not self.is_open:
                return
            if reason is not None:
                self.send_transport(close_message(reason), PRIORITIES - 1)
            self.is_open = self.is_up = False

    # ---- receiving

    def receive(self, data: bytes) -> None:
        """Take bytes. Raises ZenohProtocolError or ClosedByPeerError, after which the link is no more."""
        self.heard = True
        start, tail = 0, self._tail
        if tail:
            if self.in_pieces:
                start = _missing(tail, len(data))
            if not start:
                data = tail + data
        end = len(data)
        try:
            if start:  # hot path: of a large message one batch in four is copied here, not all that has come
                self._take_batch(tail + data[:start])
            while end - start > 1:
                at = start + 2
                start = at + (data[at - 2] | data[at - 1] << 8)
                if start > end:
                    start = at - 2
                    break
                if data.startswith(self._expected, at):  # the next frame of reliable data
                    last = self._numbers.last
                    number = last[DATA_CHANNEL] = (last[DATA_CHANNEL] + 1) & MASK
                    number = (number + 1) & MASK
                    self._expected = b'%%%b%b' % (PADDED_LOW[number & 0x3FFF], PADDED_HIGH[number >> 14])
                    at = self._take_network(data, at + 5, start)
                while at < start:
                    at = self._take_transport(data, at, start)
        except IndexError:
            raise ZenohProtocolError('a message is cut off') from None
        except UnicodeDecodeError as error:
            raise ZenohProtocolError(f'a text is no UTF-8: {error}') from None
        finally:
            # Also where a signal's handler raises in the midst of it: then only the rest of a batch is lost.
            self._tail = data[start:] if start < end else b''
            self.reads += 1

    def _take_batch(self, batch: bytes) -> None:
        """Take a whole batch, its length included."""
        at, end = LENGTH_SIZE, len(batch)
        while at < end:
            at = self._take_transport(batch, at, end)

    def _take_transport(self, data: bytes, at: int, end: int) -> int:
        """Take a message of the link itself; return where it ends."""
        header = data[at]
        kind = header & MESSAGE_ID
        if end - at > self._largest_batch:
            raise ZenohProtocolError(f'a batch of {end - at} bytes exceeds what was agreed')
        if kind in (FRAME, FRAGMENT) and self.is_up:
            return self._take_numbered(data, at, end)
        reader = Reader(data, at, end)
        if kind in (INIT, OPEN):
            self._take_handshake(reader)
        elif kind == CLOSE:
            reader.u8()
            raise ClosedByPeerError(f'the other side closed the link (reason {reader.u8()})')
        elif kind == KEEP_ALIVE and self.is_up:
            reader.u8()
            if header & MORE:
                reader.extensions()
        else:
            raise ZenohProtocolError(f'message 0x{header:02x} is not expected here')
        return reader.at

    def _take_handshake(self, reader: Reader) -> None:
        handshake = self.handshake
        answer = handshake.receive(reader)
        terms = handshake.terms
        if terms is not None:
            self.terms = terms
            self.zid, self.role = terms.zid, terms.role
            self._sent = [terms.first_sent] * CHANNELS
            self._numbers = ReceivedNumbers(terms.first_received)
            self._expected = b'%%%b' % encode_padded(terms.first_received)
            self.room = terms.batch_size - HEAD_SIZE
            self._largest_batch = terms.batch_size - 2
            self._marks_first = terms.patch > 0
            self._has_priorities = terms.qos
        if answer:
            self.send_transport(answer)
        if terms is not None:
            self.is_up = True
            self.owner.link_is_up(self)

    def _take_numbered(self, data: bytes, at: int, end: int) -> int:
        """Take a frame or a piece; return where it ends."""
        header = data[at]
        reader = Reader(data, at + 1, end)
        number = reader.z()
        priority, found = DATA_PRIORITY, {}
        if header & MORE:
            found = reader.extensions({_PRIORITY, IS_FIRST, IS_GIVEN_UP})
            named = found.get(_PRIORITY, DATA_PRIORITY)
            assert isinstance(named, int)
            if named >= PRIORITIES or (_PRIORITY in found and not self._has_priorities):
                raise ZenohProtocolError(f'priority {named} on a link that has it not')
            priority = named
        channel = 2 * priority + bool(header & IS_RELIABLE)
        gap = self._numbers.advance(channel, number)
        if not gap:
            return end  # it came before
        if channel == DATA_CHANNEL:
            self._expected = b'%%%b' % encode_padded((number + 1) & MASK)
        if header & MESSAGE_ID == FRAME:
            if channel in self._reassembly:
                self._reassembly[channel].clear()
            return self._take_network(data, reader.at, end)
        reassembly = self._reassembly.get(channel)
        if reassembly is None:
            reassembly = Reassembly(has_marks=self._marks_first, limit=MESSAGE_LIMIT)
            self._reassembly[channel] = reassembly
        start = reader.at
        # hot path: most pieces of 1 MB are not copied here, which saves 0.1 ms. What is shown of `data` keeps
        # all of it, so only what is a good part of it.
        is_shown = (end - start) * MOST_KEPT >= len(data)
        self.in_pieces = bool(header & MORE_PIECES)
        message = reassembly.add(
            memoryview(data)[start:end] if is_shown else data[start:end],
            gap=gap,
            first=IS_FIRST in found,
            more=self.in_pieces,
            given_up=IS_GIVEN_UP in found,
        )
        if message is not None and message[0] & MESSAGE_ID >= FIRST_NETWORK_ID:
            self._take_network(message, 0, len(message))
        return end

    def _take_network(self, data: bytes, at: int, end: int) -> int:
        """Take network messages until the batch ends or a message of the link begins; return where."""
        while at < end:
            header = data[at]
            kind = header & MESSAGE_ID
            if kind == PUSH:
                form = self.push_forms.get(data[at : at + KEY_SIZE])
                if form is not None and data.startswith(form.head, at):
                    at = self._take_alike(data, at, end, form)
                else:
                    at = self._take_push(data, at, end)
            elif kind == RESPONSE:
                at = self._take_response(data, at, end)
            elif kind == RESPONSE_FINAL:
                request, at = read_request_id(data, at + 1)
                if header & MORE:
                    if data[at] == QOS and data[at + 1] < MORE:  # hot path: as rmw_zenoh has it
                        at += 2
                    else:
                        _, at = read_extensions(data, at)
                self.owner.last_word(self, request)
            elif kind == REQUEST:
                at = self._take_request(data, at, end)
            elif kind < FIRST_NETWORK_ID:
                return at
            else:
                reader = Reader(data, at, end)
                if kind == DECLARE:
                    self.owner.declaration_came(self, read_declaration(reader))
                elif kind == INTEREST:
                    self.owner.interest_came(self, read_interest(reader))
                elif kind == OAM:
                    self.owner.nodes_came(self, self.link_states.read(reader))
                at = reader.at
            if at > end:
                raise ZenohProtocolError('a message is cut off')
        return at

    def _take_alike(self, data: bytes, at: int, end: int, form: PushForm) -> int:
        """Take all messages of one form that follow one another; return where they end.

        hot path: what a flood consists of. A message so takes 1.0 µs, not 2.4 as any other.
        """
        head, middle, middle_at, attachment_at, attachment_size, key, callbacks = form
        stamp_at, stamp_end = len(head), attachment_at - 2
        while data.startswith(middle, at + middle_at):
            start = at + attachment_at
            size_at = start + attachment_size
            size = data[size_at]
            payload_at = size_at + 1
            if size > 0x7F:
                size, payload_at = decode_z(data, size_at)
                if size >= LARGE:
                    break
            next_at = payload_at + size
            if next_at > end:
                raise ZenohProtocolError('a PUT is cut off')
            stamp = data[at + stamp_at : at + stamp_end]
            sample = new_sample((key, data[payload_at:next_at], data[start:size_at], stamp, None))
            at = next_at
            for callback in callbacks:
                try:
                    callback(sample)
                except Exception as error:
                    self.owner.callback_failed(error)
            if at == end or not data.startswith(head, at):
                return at
        return self._take_push(data, at, end)

    def _take_push(self, data: bytes, at: int, end: int) -> int:
        """Take one message of any form; return where it ends."""
        begin = at
        header = data[at]
        scope, suffix, at = read_wire_key(data, at + 1, header)
        if header & MORE:
            _, at = read_extensions(data, at)
        is_senders = header & IS_SENDERS
        where = (scope, is_senders, suffix) if suffix else scope | is_senders << 16
        receivers = self.push_receivers.get(where)
        if receivers is None:
            receivers = self.owner.receivers(self, scope, suffix, is_senders)
        body = at
        sample, at = read_body(data, at, end, receivers.key)
        if not suffix and sample.attachment is not None and data[body] == PUT_OF_ROS:
            form = push_form(data[begin : body + 1], sample, receivers.callbacks)
            if form is not None and len(self.push_forms) < ROUTES_LIMIT:
                self.push_forms[form.head[:KEY_SIZE]] = form
            if self.push_receivers.get(where) is not receivers:  # forgotten meanwhile, by another thread
                self.push_forms.clear()
        for callback in receivers.callbacks:
            try:
                callback(sample)
            except Exception as error:
                self.owner.callback_failed(error)
        return at

    def forget_receivers(self) -> None:
        """Who gets what is put has changed, or what a key's number means."""
        self.push_receivers.clear()
        self.push_forms.clear()

    def _take_request(self, data: bytes, at: int, end: int) -> int:
        header = data[at]
        request, start = read_request_id(data, at + 1)
        form = self.request_forms.get(data[start : start + KEY_SIZE])
        if form is not None and header == form.header and data.startswith(form.head, start):
            alike, at = read_alike_query(form, data, start + len(form.head), end)
            if alike is not None:
                self.owner.query_came(self, request, form.where, form.qos, alike)
                return at
        scope, suffix, at = read_wire_key(data, start, header)
        qos = 5
        if header & MORE:
            qos, at = read_extensions(data, at)
        query, at = read_query(data, at, end)
        where = (scope, suffix, header & IS_SENDERS)
        if not suffix and len(self.request_forms) < ROUTES_LIMIT:
            form = request_form(data, header, start, at, where, qos, query)
            if form is not None:
                self.request_forms[data[start : start + KEY_SIZE]] = form
        self.owner.query_came(self, request, where, qos, query)
        return at

    def _take_response(self, data: bytes, at: int, end: int) -> int:
        header = data[at]
        request, at = read_request_id(data, at + 1)
        scope, suffix, at = read_wire_key(data, at, header)
        form = None if scope else self.reply_forms.get(suffix)
        if form is not None and header == form.header and data.startswith(form.head, at):
            alike, next_at = read_alike_reply(form, data, at + len(form.head), end)
            if alike is not None:
                self.owner.reply_came(self, request, alike)
                return next_at
        start = at
        if header & MORE:
            _, at = read_extensions(data, at)
        key = self.owner.reply_key(self, request, scope, suffix, header & IS_SENDERS)
        answer, at = read_reply(data, at, end, key or '')
        if key is not None:
            if not scope and type(answer) is Sample and len(self.reply_forms) < ROUTES_LIMIT:
                form = reply_form(data, header, start, at, answer)
                if form is not None:
                    self.reply_forms[suffix] = form
            self.owner.reply_came(self, request, answer)
        return at

    def key_of(self, scope: int, suffix: bytes | str, own: dict[int, str], is_senders: int) -> str | None:
        """Return the key that the other side names, `own` being our ids; None for an id that is unknown."""
        text = suffix if isinstance(suffix, str) else suffix.decode()
        if not scope:
            return text
        base = (self.expressions if is_senders else own).get(scope)
        return None if base is None else base + text
