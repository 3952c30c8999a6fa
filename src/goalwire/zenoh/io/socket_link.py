"""One connection: reads bytes for its link, writes the bytes of its link, and closes both."""

from __future__ import annotations

import socket
from collections.abc import Callable, Sequence
from contextlib import suppress
from time import monotonic
from typing import TYPE_CHECKING, Protocol

from goalwire.concurrency.poller import IN, OUT, Poller
from goalwire.concurrency.sigpipe import NO_SIGPIPE, refuse_sigpipe
from goalwire.concurrency.wire_poller import Sleeper
from goalwire.freed_memory import MUCH, keep_freed_memory, return_freed_memory
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.frames import ClosedByPeerError
from goalwire.zenoh.protocol.handshake import Handshake
from goalwire.zenoh.protocol.link import KEEP_ALIVES
from goalwire.zenoh.protocol.outgoing import QUEUE_LIMIT, Outgoing
from goalwire.zenoh.protocol.primitives import MAX_LINKS, TO_SELF, ZenohProtocolError
from goalwire.zenoh.protocol.session_protocol import SessionProtocol

if TYPE_CHECKING:
    from goalwire.zenoh.protocol.channels import Buffer

READ_SIZE = 65536
READ_SIZE_LARGE = 1 << 18
"""Bytes to read at once in the midst of a large message."""
_MANY = 8
"""A message of more pieces than this counts as large."""
_READS_AT_ONCE = 8
"""How many reads in a row a connection gets in the midst of a large message, before other connections are
read."""

ENOUGH_ROOM = QUEUE_LIMIT // 2
"""Threads that wait for room go on when fewer bytes than this wait for the socket."""

LEAST_PERIOD_S = 0.01
"""The shortest time between two checks of the leases."""


_FLAGS = (NO_SIGPIPE,)
_NOTHING_ELSE = ((),)
"""The second argument of `sendmsg`: no descriptors are sent along."""

JOINED_SIZE = 1 << 16
"""Bytes of several buffers that are joined to be sent at once."""


def join_first(buffers: Sequence[Buffer]) -> Buffer:
    """Return the first of several buffers, small ones joined. For streams that send one buffer at a time."""
    joined: list[Buffer] = []
    size = 0
    for each in buffers:
        if joined and size + len(each) > JOINED_SIZE:
            break
        joined.append(each)
        size += len(each)
    return joined[0] if len(joined) == 1 else b''.join(joined)


class SocketLinkOwner(Protocol):
    """A session, as far as its connections need it."""

    protocol: SessionProtocol

    @property
    def lease_ms(self) -> int:
        """How long this side may be silent before the others close the link."""

    def take_end(self, socket_link: SocketLink, why: str, is_fault: bool) -> None:
        """Take note that a connection has ended, why, and whether the other side broke the protocol."""

    def wait_for_room(self, socket_link: SocketLink, is_answer: bool) -> None:
        """Block until fewer bytes wait for a connection, if this thread may block."""

    def hold(self, outgoing: Outgoing) -> None:
        """Have a link send its held-back messages soon."""

    def refuse(self, kind: str, reason: object) -> None:
        """Count a received message that is ignored."""

    def note_running(self, now: float) -> None:
        """Take note that this process runs; `now` in s."""


class SocketLink:
    """A connected socket and its link; it is the link's `Connection`."""

    can_hold = True

    def __init__(
        self, owner: SocketLinkOwner, sock: socket.socket, handshake: Handshake, poller: Poller
    ) -> None:
        self._owner = owner
        self._socket = sock
        self._fd = sock.fileno()
        self._poller = poller
        self.waiting: set[Sleeper] = set()
        """Threads that wait for room in the link's queue."""
        self._wants_room = False
        self._has_ended = False
        self.took_too_long = False
        """True if the handshake was given up, since it took too long."""
        self._recv: Callable[[int], bytes] = sock.recv
        self._send: Callable[[Buffer, int], int] = sock.send
        self._sendmsg: Callable[[list[Buffer], tuple[()], int], int] = (
            sock.sendmsg
            if hasattr(sock, 'sendmsg')
            else lambda buffers, _, flags: sock.send(join_first(buffers), flags)
        )
        refuse_sigpipe(sock)
        self.link = owner.protocol.make_link(handshake, self, lease_ms=owner.lease_ms)
        self.outgoing = self.link.outgoing
        self.connects = handshake.connects
        self._receive = self.link.frames.receive
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._timer = poller.call_later(bounds.HANDSHAKE_S, self._check_handshake)

    def start(self, handshake_s: float | None = None) -> None:
        """Begin to read and write; do nothing if the session was closed meanwhile.

        `handshake_s` is how long the handshake may take, if not as long as usual.
        """
        with self.outgoing.lock:
            if self._has_ended:  # the descriptor may belong to another file by now
                return
            if handshake_s is not None:
                self._timer.cancel()
                self._timer = self._poller.call_later(handshake_s, self._check_handshake)
            self._poller.register(self._fd, IN, self.on_ready)
        self._start_link()

    def _start_link(self) -> None:
        """Start the link. With TLS, its handshake comes first."""
        self.link.start()

    # ---- writing: under the link's lock
    # A signal's handler may raise after a C function has returned, before Python has stored the result, which
    # would be lost. `map` and the unpacking of its one result are one bytecode, so the result is kept.

    def wait_for_room(self, is_answer: bool) -> None:
        """Block until fewer bytes wait, if this thread may block."""
        self._owner.wait_for_room(self, is_answer)

    def hold(self, outgoing: Outgoing) -> None:
        """Have the link send its held-back messages soon."""
        self._owner.hold(outgoing)

    def write(self, data: Buffer) -> int:
        """Write as much as the socket takes."""
        try:
            (taken,) = map(self._send, (data,), _FLAGS)
            return taken  # noqa: TRY300
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError as error:
            self._fail(error)
            return len(data)

    def write_many(self, buffers: list[Buffer]) -> int:
        """Write some buffers at once, as far as the socket takes them."""
        if len(buffers) > _MANY:
            keep_freed_memory()
        try:
            (taken,) = map(self._sendmsg, (buffers,), _NOTHING_ELSE, _FLAGS)
            return taken  # noqa: TRY300
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError as error:
            self._fail(error)
            return sum(map(len, buffers))

    def _fail(self, error: OSError) -> None:
        """End a broken connection later, on the thread that reads: the caller holds the link's lock."""
        reason = error.strerror or str(error)
        self._poller.call(lambda: self.end(f'the connection broke: {reason}'))

    def request_flush(self) -> None:
        """Have the queued data written once the socket has room. The caller holds the link's lock."""
        if not self._wants_room:
            self._poller.modify(self._fd, IN | OUT)
            self._wants_room = True  # set last: a signal's handler may raise in the line above
        if self.outgoing.overflowed:
            self._poller.call(self._check)

    def watch_room(self) -> None:
        """Wake the threads that wait for room once there is some."""
        with self.outgoing.lock:
            if not self._has_ended:
                self.request_flush()

    # ---- calls of the poller

    def on_ready(self, events: int) -> None:
        """Read if bytes have come; write queued bytes if the socket has room."""
        if events & OUT and self._wants_room:
            outgoing = self.outgoing
            if outgoing.flush():
                outgoing.section.run(self._forget_room)
            if self.waiting and outgoing.queue.size <= ENOUGH_ROOM:
                self.wake_waiting()
        if events & ~OUT:
            self._read()

    def _forget_room(self) -> None:
        """Stop waiting for room in the socket, unless something was queued since."""
        if not self._has_unsent():
            self._wants_room = False
            self._poller.modify(self._fd, IN)

    def _has_unsent(self) -> bool:
        return bool(self.outgoing.queue.size)

    def _read(self) -> None:
        frames = self.link.frames
        reads = frames.reads
        size = READ_SIZE
        try:
            for _ in range(_READS_AT_ONCE):
                data = self._recv(size)
                reads += 1
                if not data:
                    self.end('the other side has hung up')
                    return
                self._receive(data)
                # The callbacks of small messages run before more is read. A subscription keeps only a limited
                # number of messages; the rest waits in the socket, so that the publisher notices.
                if len(data) < size or not frames.in_pieces or self._has_ended:
                    return
                keep_freed_memory()
                size = READ_SIZE_LARGE
        except (BlockingIOError, InterruptedError):
            return
        except OSError as error:
            self.end(f'the connection broke: {error.strerror or error}')
        except ClosedByPeerError as error:
            self.end(str(error))
        except ZenohProtocolError as error:
            self.end(str(error), error.reason, is_fault=error.reason not in {MAX_LINKS, TO_SELF})
        except BaseException:
            # a signal's handler raised between `_recv` and `_receive`: bytes are lost
            if frames.reads != reads:
                self.end('its reader was interrupted')
            raise

    def wake_waiting(self) -> None:
        """Wake the threads that wait for room, so that they look again."""
        for sleeper in list(self.waiting):
            sleeper.wake()

    # ---- time

    def _check_handshake(self) -> None:
        if not self.link.is_up:
            self.took_too_long = True
            self.end('the handshake took too long', is_fault=True)

    def came_up(self) -> None:
        """Watch the leases from now on: the handshake is done."""
        self._timer.cancel()
        terms = self.link.terms
        assert terms is not None
        self._period = max(min(self.link.keep_alive_s, terms.lease_ms / 1000 / KEEP_ALIVES), LEAST_PERIOD_S)
        self._timer = self._poller.call_later(self._period, self._check)

    def _check(self) -> None:
        if self._has_ended:
            return
        self._timer.cancel()  # the timer is set anew first: a signal's handler may raise below
        self._timer = self._poller.call_later(self._period, self._check)
        self.outgoing.tick()
        now = monotonic()
        self._owner.note_running(now)
        if self.link.frames.discard_stale(now) >= MUCH:
            return_freed_memory()
        try:
            self.link.check_lease(now)
        except ZenohProtocolError as error:
            self.end(str(error), error.reason)

    # ---- ending

    def end(self, why: str, reason: int | None = None, *, is_fault: bool = False) -> None:
        """Close the connection, and tell the other side the `reason` if there is one. Idempotent."""
        with self.outgoing.lock:
            if self._has_ended:
                return
            self._has_ended = True
        # CLOSE is written while the socket is open. The descriptor leaves the poller before it is closed:
        # afterwards the system may give its number to another file.
        self._timer.cancel()
        self.link.close(reason)
        self._say_goodbye()
        self._poller.unregister(self._fd)
        with suppress(OSError):  # the connection was broken already
            self._socket.shutdown(socket.SHUT_RDWR if reason is None else socket.SHUT_WR)
        self._socket.close()
        freed = self.link.frames.discard_pieces()
        self._owner.take_end(self, why, is_fault)
        if freed >= MUCH:
            return_freed_memory()

    def _say_goodbye(self) -> None:
        """End the layer below the link, for example TLS. A plain socket has nothing to send here."""
