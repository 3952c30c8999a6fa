"""Connects without blocking: to configured addresses for ever, to nodes from gossip for a limited time.

A connection is started, and checked again when its socket is writable. A host name that needs DNS is looked
up on a thread of its own, which ends with the answer. After a failure the next address is tried, and after
the last address comes a pause, which doubles from one round to the next.

After a power cut a thousand sessions dial their router at once. A handshake that is given up has cost the
router as much as one that succeeds, and it comes again. So the session waits longer for the next handshake
after one that took too long, pauses longer after one that has failed than after a closed port, and makes
each pause a random part shorter than the others do.
"""

from __future__ import annotations

import errno
import os
import socket
from collections import deque
from collections.abc import Callable
from threading import Lock, RLock, Thread
from typing import Any

from goalwire.concurrency.forks import open_privately
from goalwire.concurrency.poller import IN, OUT, Poller, Timer
from goalwire.errors import TransportError
from goalwire.records import record
from goalwire.zenoh.io.endpoints import Endpoint, is_quickly_resolved, parse, resolve
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.bounds import GOSSIP_CONNECT_S

CONNECT_S = 10.0
"""How long a connection to one address may stay unanswered."""
MOST_AFTER_HANDSHAKE_S = 4.0
"""How long the pauses after failed handshakes grow, if the pauses after closed ports stay shorter."""
_UNDER_WAY = {errno.EINPROGRESS, errno.EWOULDBLOCK, getattr(errno, 'WSAEWOULDBLOCK', errno.EWOULDBLOCK)}


@record
class Retry:
    """The pauses between rounds of dialling, in s, and the number of `rounds`; None: no limit."""

    first_s: float = 1.0
    most_s: float = 4.0
    factor: float = 2.0
    rounds: int | None = None


def _shorten(pause: float) -> float:
    """Return a random time between half the pause and the whole one."""
    # `random` takes some milliseconds to import
    return pause * (1 + int.from_bytes(os.urandom(2), 'little') / 65535) / 2


class DialSlots:
    """Limits how many nodes from gossip are dialled at one time; the others wait for their turn.

    Only the thread that reads uses it.
    """

    def __init__(self, most: int) -> None:
        self._free = most
        self._waiting: deque[Callable[[], None]] = deque()

    def take(self, start: Callable[[], None]) -> None:
        """Call `start` as soon as there is a slot; `give` must follow."""
        if self._free:
            self._free -= 1
            start()
        else:
            self._waiting.append(start)

    def give(self) -> None:
        """Give a slot back, or pass it to the next node that waits."""
        if self._waiting:
            self._waiting.popleft()()
        else:
            self._free += 1


class LookUps:
    """Looks names up on a few threads, which end when no name is left."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._lock = Lock()
        self._waiting: deque[Callable[[], None]] = deque()
        self._threads = 0

    def add(self, ask: Callable[[], None]) -> None:
        """Call `ask`, which looks a name up, on one of the threads."""
        with self._lock:
            self._waiting.append(ask)
            if self._threads >= self._most:
                return
            self._threads += 1
        Thread(target=self._run, name='look up names of gossip', daemon=True).start()

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._threads -= 1
                    return
                ask = self._waiting.popleft()
            ask()

    def clear(self) -> None:
        """Drop the names that still wait to be looked up."""
        self._waiting.clear()


class Dial:
    """Connects to one node, at one of its addresses."""

    def __init__(
        self,
        locators: tuple[str, ...],
        poller: Poller,
        retry: Retry,
        *,
        when_connected: Callable[[Dial, socket.socket], None],
        when_failed: Callable[[Dial], None],
        expected: bytes | None = None,
        open_s: float | None = None,
        slots: DialSlots | None = None,
        look_ups: LookUps | None = None,
    ) -> None:
        """`when_failed` is called after each failed round; `expected` is the id that must answer, if known.

        A handshake may take `open_s` at most: the first one as long as usual, the one after it longer if it
        took too long. All dials of nodes from gossip share `slots` and `look_ups`.
        """
        self._open_s = bounds.HANDSHAKE_S if open_s is None else open_s
        self.handshake_s = min(bounds.HANDSHAKE_S, self._open_s)
        """How long the next handshake may take."""
        self._slots = slots
        self._has_slot = self._awaits_slot = False
        self._look_ups = look_ups
        self._connect_s = CONNECT_S if slots is None else GOSSIP_CONNECT_S
        self.expected = expected
        self.locators = locators
        self.failed_rounds = 0
        self.is_up = False
        """True while the link that this dial led to is up."""
        self.is_over = False
        self.error = ''
        self.address = ''
        """The address that was dialled last, as it was given."""
        self._poller = poller
        self._retry = retry
        self._when_connected = when_connected
        self._when_failed = when_failed
        self._pause = retry.first_s
        self._most_pause_s = retry.most_s
        """How long the pause after this round may be."""
        self._endpoints: list[tuple[str, Endpoint]] = []
        self._addresses: list[tuple[socket.AddressFamily, Any]] = []
        self._lock = RLock()
        """Guards the socket: any thread may close the session while the reading thread dials."""
        self._socket: socket.socket | None = None
        self._timer: Timer | None = None

    def start(self) -> None:
        """Begin one round through the addresses."""
        if self.is_over:
            return
        if self._slots is None:
            self._begin_round()
        elif not self._awaits_slot and not self._has_slot:
            self._awaits_slot = True
            self._slots.take(self._begin_with_slot)

    def _begin_with_slot(self) -> None:
        """Begin a round, or pass the slot on if the dial was closed while it waited."""
        self._awaits_slot, self._has_slot = False, True
        if self.is_over:
            self._give_slot()
        else:
            self._begin_round()

    def _give_slot(self) -> None:
        if self._slots is not None and self._has_slot:
            self._has_slot = False
            self._poller.call(self._slots.give)

    def _begin_round(self) -> None:
        """Parse all addresses anew and try the first. A malformed address only sets `error`."""
        self._most_pause_s = self._retry.most_s
        self._endpoints, self._addresses = [], []
        for locator in self.locators:
            try:
                self._endpoints.append((locator, parse(locator)))
            except TransportError as error:
                self.error = str(error)
        self._next()

    def _next(self) -> None:
        """Try the next address."""
        while not self.is_over:
            if self._addresses:
                if self._connect(*self._addresses.pop(0)):
                    return
            elif self._endpoints:
                self.address, endpoint = self._endpoints.pop(0)
                if not is_quickly_resolved(endpoint.host):
                    self._look_up(endpoint)
                    return
                try:
                    self._addresses = resolve(endpoint)
                except OSError as error:
                    self.error = str(error)
            else:
                self._pause_after_round()
                return

    def _look_up(self, endpoint: Endpoint) -> None:
        """Look a host name up on a thread, and go on with the addresses on the thread that reads."""

        def ask() -> None:
            try:
                found = resolve(endpoint)
            except OSError as error:
                self.error = str(error)
                found = []
            self._poller.call(lambda: self._on_found(found))

        if self._look_ups is None:
            Thread(target=ask, name=f'look up {endpoint.host}', daemon=True).start()
        else:
            self._look_ups.add(ask)

    def _on_found(self, addresses: list[tuple[socket.AddressFamily, Any]]) -> None:
        self._addresses = addresses
        self._next()

    def _connect(self, family: socket.AddressFamily, address: Any) -> bool:
        """Begin to connect; False if that has failed at once."""
        try:
            sock = open_privately(lambda: socket.socket(family, socket.SOCK_STREAM))
        except OSError as error:
            self.error = str(error)
            return False
        sock.setblocking(False)
        code = sock.connect_ex(address)
        if code and code not in _UNDER_WAY:
            self.error = os.strerror(code)
            sock.close()
            return False
        with self._lock:
            if self.is_over:
                sock.close()
                return True
            self._socket = sock
            self._timer = self._poller.call_later(self._connect_s, self._took_too_long)
            self._poller.register(sock.fileno(), IN | OUT, self._on_ready)
        return True

    def _took_too_long(self) -> None:
        self._close_socket()
        self.error = f'no answer within {self._connect_s:g} s'
        self._next()

    def _on_ready(self, _events: int) -> None:
        """Hand the connected socket over, or try the next address if the connection has failed."""
        with self._lock:
            sock = self._socket
            if sock is None:
                return
            code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
            is_connected = not code and not _is_own_end(sock)
            if is_connected:
                self._discard_socket(sock)
            else:
                self.error = os.strerror(code or errno.ECONNREFUSED)
                self._close_socket()
        if not is_connected:
            self._next()
            return
        self._when_connected(self, sock)

    def _discard_socket(self, sock: socket.socket) -> None:
        self._socket = None
        if self._timer is not None:
            self._timer.cancel()
        self._poller.unregister(sock.fileno())

    def _close_socket(self) -> None:
        with self._lock:
            sock = self._socket
            if sock is not None:
                self._discard_socket(sock)
                sock.close()

    def _pause_after_round(self) -> None:
        """End a failed round: give the slot up, then wait for the next round or give the dial up."""
        self._give_slot()
        self.failed_rounds += 1
        retry = self._retry
        if retry.rounds is not None and self.failed_rounds >= retry.rounds:
            self.is_over = True
        else:
            self._begin_after(min(self._pause, self._most_pause_s))
            self._pause = min(self._pause * retry.factor, self._most_pause_s)
        self._when_failed(self)

    def _begin_after(self, pause: float) -> None:
        self._timer = self._poller.call_later(_shorten(pause), self.start)

    def try_again(self) -> None:
        """Begin anew after a pause, since the link that this dial led to has ended."""
        self.is_up = False
        if not self.is_over:
            self._pause = self._retry.first_s
            self.failed_rounds = 0
            self._begin_after(self._pause)

    def note_refusal(self, *, took_too_long: bool) -> None:
        """Try the next address, since the handshake at this one has failed or has taken too long.

        A node from gossip often refuses because it dials this side at the same moment: that gets time first.
        """
        if took_too_long:
            self.handshake_s = min(2 * self.handshake_s, self._open_s)
        self._most_pause_s = max(self._retry.most_s, MOST_AFTER_HANDSHAKE_S)
        if self.expected is None:
            self._next()
        elif not self.is_over:
            self._pause_after_round()

    def note_success(self) -> None:
        """Take note that the link is up: failures are counted from 0 again."""
        self.is_up = True
        self._give_slot()
        self.failed_rounds = 0
        self._pause = self._retry.first_s
        self.handshake_s = min(bounds.HANDSHAKE_S, self._open_s)

    def close(self) -> None:
        """Stop dialling."""
        with self._lock:
            self.is_over = True
            self._close_socket()
        self._give_slot()
        if self._timer is not None:
            self._timer.cancel()


def _is_own_end(sock: socket.socket) -> bool:
    """True if a socket is connected to itself, which TCP allows for a free port of this machine."""
    try:
        return bool(sock.getsockname() == sock.getpeername())
    except OSError:
        return True
