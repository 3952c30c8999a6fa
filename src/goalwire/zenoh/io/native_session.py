"""A session: links to others, who waits on them, and how all of it ends."""

from __future__ import annotations

import os
import socket
from collections import Counter
from collections.abc import Callable
from functools import partial
from threading import RLock
from time import monotonic, time_ns
from typing import TYPE_CHECKING, TypeAlias

from goalwire.concurrency.forks import ForkGuard, reset_in_children
from goalwire.concurrency.leader_followers import LeaderFollowers
from goalwire.concurrency.poller import IN, IS_PORTABLE, Poller, Timer
from goalwire.concurrency.wire_poller import SleepingThread
from goalwire.errors import TransportError, peer_text
from goalwire.records import record
from goalwire.reports import LOGGER, RejectCounters, is_told, report_failure
from goalwire.zenoh.io.dialler import Dial, DialSlots, LookUps, Retry
from goalwire.zenoh.io.endpoints import TlsFiles, locators_of, parse, resolve
from goalwire.zenoh.io.flusher import Flusher
from goalwire.zenoh.io.socket_link import SocketLink
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.handshake import Handshake, Identity
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_state import Node, connects_to
from goalwire.zenoh.protocol.outgoing import QUEUE_LIMIT, Outgoing
from goalwire.zenoh.protocol.primitives import GENERIC, UNRESPONSIVE, show_id
from goalwire.zenoh.protocol.session_protocol import SessionProtocol
from goalwire.zenoh.protocol.transport import Role

if TYPE_CHECKING:
    from goalwire.zenoh.io.tls import Tls

CONNECTING_S = 1.0
"""How long opening waits for an address that neither answers nor refuses."""
READING_TURNS = 64
"""How often every link is read before its end is believed to have been seen. Each time takes up to 64 KiB."""
RELINK_S = 3.0
"""How long links may take to come back that others have closed while this process was stopped."""
OTHERS_S = 0.1
"""How long opening waits for nodes that are to connect to this one."""
CLOSING_S = 1.0
"""How long closing waits for the others to take what was sent."""
ROOM_S = 60.0
"""How long a message waits for room, before its link is given up."""
_TO_NODES = Retry(first_s=0.1, most_s=4.0, rounds=10)


@record
class Settings:
    """What a session is opened with."""

    role: Role = Role.PEER
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ('tcp/localhost:0',)
    zid: bytes = b''
    """Empty: by chance."""
    lease_ms: int = 60_000
    retry: Retry = Retry()
    meets_peers: bool = True
    """Whether it connects to peers that routers tell of."""
    tls: TlsFiles = TlsFiles()
    """For addresses that begin with tls/."""
    untimed_s: float = 600.0
    """How long a query without a time may take; rmw_zenoh's ten minutes."""
    must_connect: bool | None = None
    """Whether opening fails where `connect` is not reached; None: a client's does, a peer's does not."""
    connecting_s: float = 0.0
    """How long it goes on trying where it must; 0: each address once."""
    portable: bool = IS_PORTABLE
    """Whether to do without what only Linux has."""
    advice: str = 'check that these addresses can be reached'
    """What the error says to do if `connect` must be reached and is not."""


LinkMaker: TypeAlias = Callable[[socket.socket], Callable[..., SocketLink]]
"""Returns the class, or what stands for it, of the link on a connected socket."""


def _plain(_sock: socket.socket) -> type[SocketLink]:
    return SocketLink


def _most_descriptors() -> int:
    """Return how many files and sockets this process may have open."""
    try:
        import resource
    except ImportError:  # Windows
        return 2 * bounds.MOST_LINKS
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return most if most != resource.RLIM_INFINITY else 2 * bounds.MOST_LINKS


class LinkWatch:
    """Somebody who is told of links."""

    def __init__(self, watches: set[LinkWatch], on_link: Callable[[Link, str], None]) -> None:
        self.on_link = on_link
        self._watches = watches
        watches.add(self)

    def undeclare(self) -> None:
        """Tell no more."""
        self._watches.discard(self)


class NativeSession:
    """One open session. `protocol` declares, puts and asks; in `wire_poller` idle threads may wait."""

    def __init__(self, settings: Settings) -> None:
        """Open it, and wait until it knows what those know whom it meets. Raises TransportError."""
        zid = settings.zid or os.urandom(15) + bytes((1 + os.urandom(1)[0] % 255,))
        self.guard = ForkGuard()
        self.rejects = RejectCounters()
        """What peers sent and this session ignored, by kind."""
        self.lease_ms = settings.lease_ms
        self.protocol = SessionProtocol(
            Identity(zid, settings.role, settings.lease_ms), self, clock=monotonic, wall_clock_ns=time_ns
        )
        self.id = self.protocol.id
        name = f'goalwire-zenoh {self.id[:8]}'
        self._settings = settings
        self._must_connect = (
            settings.role is Role.CLIENT if settings.must_connect is None else settings.must_connect
        )
        self._flusher = Flusher(f'{name} flusher')
        self._poller = Poller(
            f'Zenoh session {self.id}',
            portable=settings.portable,
            before_sleep=(self._flusher.held, self._flusher.flush),
            awaited=self.protocol.queries.pending,
        )
        self.wire_poller = LeaderFollowers(self._poller, name)
        self._lock = RLock()
        self._links: dict[Link, SocketLink] = {}
        self._dials: dict[object, Dial] = {}
        self._dialled: dict[Link, Dial] = {}
        self._sleepers: set[SleepingThread] = set()
        self._listeners: list[socket.socket] = []
        self._is_closing = False
        self._is_closed = False
        self._watches: set[LinkWatch] = set()
        self._expiry: float = float('inf')
        self._expiry_timer: Timer | None = None
        self._secured: Tls | None = None
        self._faults: Counter[str] = Counter()
        self._greetings: dict[Link, SocketLink] = {}
        """Links that others have opened and that are in their handshake."""
        self._lost_asleep: set[bytes] = set()
        """The sessions whose links have ended while this process was stopped."""
        self._relinking: Timer | None = None
        """Runs from the end of a stop until the links that are left are believed again."""
        self._most_links = min(bounds.MOST_LINKS, _most_descriptors() // 2)
        self._slots = DialSlots(bounds.MOST_DIALS)
        self._look_ups = LookUps(bounds.MOST_LOOK_UPS)
        reset_in_children(self)
        try:
            for each in settings.listen:
                self._listen(each)
            self.wire_poller.start()
            self._dial_configured()
            self._wait_until_settled()
        except BaseException:
            self.close()
            raise

    # ---- listening

    def _listen(self, text: str) -> None:
        endpoint = parse(text)
        make = self._tls().taking() if endpoint.protocol == 'tls' else _plain
        try:
            family, address = resolve(endpoint, passive=True)[0]
            listener = socket.create_server(address[:2], family=family, backlog=128)
        except OSError as error:
            raise TransportError(f"cannot listen on '{text}': {error.strerror or error}") from None
        listener.setblocking(False)
        self._listeners.append(listener)
        self.protocol.gossip.locators += tuple(locators_of(listener, endpoint.protocol))
        self._poller.register(listener.fileno(), IN, lambda _: self._accept(listener, make))

    def _accept(self, listener: socket.socket, make: LinkMaker) -> None:
        while not self._is_closing:
            try:
                sock, _ = listener.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:  # too many open files: others may end soon
                self._warn(f'no connection can be taken: {error.strerror}; tried again each second')
                self._poller.unregister(listener.fileno())
                self._poller.call_later(1.0, lambda: self._accept_again(listener, make))
                return
            if len(self._links) >= self._most_links:
                self.rejects.add('connection', f'there are {self._most_links} links')
                sock.close()
                continue
            if len(self._greetings) >= bounds.MOST_GREETINGS:
                oldest = next(iter(self._greetings.values()))
                self.rejects.add('connection', f'{bounds.MOST_GREETINGS} newer ones are in their handshake')
                oldest.end('others wait')
            self._add(sock, make)

    def _accept_again(self, listener: socket.socket, make: LinkMaker) -> None:
        if not self._is_closing:
            self._poller.register(listener.fileno(), IN, lambda _: self._accept(listener, make))

    # ---- connecting

    def _dial_configured(self) -> None:
        connect = self._settings.connect
        groups = (
            [connect] if self._settings.role is Role.CLIENT and connect else [(each,) for each in connect]
        )
        for group in groups:
            if any(parse(each).protocol == 'tls' for each in list(group)):
                self._tls().check_dialling()
            self._dial(group, group, self._settings.retry)
        for dial in list(self._dials.values()):
            self._poller.call(dial.start)

    def _dial(
        self, name: object, locators: tuple[str, ...], retry: Retry, expected: bytes | None = None
    ) -> Dial:
        dial = Dial(
            locators,
            self._poller,
            retry,
            when_connected=self._connected,
            when_failed=self._failed,
            expected=expected,
            slots=None if expected is None else self._slots,
            look_ups=None if expected is None else self._look_ups,
        )
        self._dials[name] = dial
        return dial

    def meet(self, node: Node) -> None:
        """Connect to a node that a router told of. On the thread that reads."""
        if not self._settings.meets_peers or self._is_closing or node.zid in self._dials:
            return
        if len(self._links) >= self._most_links:
            self.rejects.add('node of gossip', f'there are {self._most_links} links')
            self.protocol.gossip.forget(node.zid)
        else:
            self._dial(node.zid, node.locators, _TO_NODES, node.zid).start()

    def _connected(self, dial: Dial, sock: socket.socket) -> None:
        if self._is_closing:
            sock.close()
        else:
            where = parse(dial.address)
            self._add(sock, self._tls().dialling(where.host) if where.protocol == 'tls' else _plain, dial)

    def _tls(self) -> Tls:
        """Return what speaks TLS here; imported when it is needed, which costs some 10 ms."""
        if self._secured is None:
            from goalwire.zenoh.io.tls import Tls

            self._secured = Tls(self._settings.tls)
        return self._secured

    def _failed(self, dial: Dial) -> None:
        if dial.is_over and dial.expected is not None:
            self._dials.pop(dial.expected, None)
            self.protocol.gossip.forget(dial.expected)
        self.wake_all()

    # ---- links

    def _add(self, sock: socket.socket, make: LinkMaker, dial: Dial | None = None) -> None:
        try:
            handshake = Handshake(
                self.protocol.identity,
                connects=dial is not None,
                random=os.urandom,
                expected=None if dial is None else dial.expected,
                is_linked=self._is_met,
            )
            new = make(sock)(self, sock, handshake, self._poller)
            self._links[new.link] = new
            if dial is None:
                self._greetings[new.link] = new
        except BaseException:  # of a signal's handler: nobody else has the socket, and its other end waits
            sock.close()
            raise
        if dial is not None:
            self._dialled[new.link] = dial
        new.start()

    def _is_met(self, zid: bytes) -> bool:
        """Whether there is a link to a session, or one that was begun here is in its handshake.

        So links that two sessions open to each other at once do not cross: eclipse-zenoh (1.10.2) may tell
        nothing any more over the one that stays.
        """
        return self.protocol.is_linked(zid) or any(
            dial.expected == zid and not link.is_up for link, dial in list(self._dialled.items())
        )

    def welcome(self, link: Link) -> None:
        """Take note that a link is up. Another thread may have ended it since, by closing the session."""
        self._greetings.pop(link, None)
        socket_link = self._links.get(link)
        if socket_link is None:
            return
        dial = self._dialled.get(link)
        if dial is not None:
            dial.worked()
        other = self._dials.get(link.zid)
        if other is not None and other is not dial:
            other.close()
            self._dials.pop(link.zid, None)
        socket_link.came_up()
        self.note_running(monotonic())
        for watch in list(self._watches):
            watch.on_link(link, self._address_of(link))

    def close_link(self, link: Link, why: str, reason: int) -> None:
        """Close a link soon."""

        def close() -> None:
            socket_link = self._links.get(link)
            if socket_link is not None:
                socket_link.end(why, reason)

        self._poller.call(close)

    def take_end(self, socket_link: SocketLink, why: str, is_fault: bool) -> None:
        """Take note that a connection has ended; connect again, if this side is to do that."""
        link = socket_link.link
        self._links.pop(link, None)
        self._greetings.pop(link, None)
        self.note_running(monotonic())
        if self._relinking is not None and link.zid:
            self._lost_asleep.add(link.zid)
        was_up = link.terms is not None
        if is_fault and not self._is_closing:
            self._tell_fault(link, why)
        self.protocol.lose_link(link)
        socket_link.wake_waiting()
        self.wake_all()
        dial = self._dialled.pop(link, None)
        if self._is_closing:
            return
        is_linked = bool(link.zid) and self.protocol.is_linked(link.zid)
        if is_linked and dial is not None and dial.expected is not None:
            dial.close()
            self._dials.pop(dial.expected, None)
        elif dial is not None:
            dial.error = why
            if was_up:
                dial.try_again()
            else:
                dial.refused()
        elif was_up and (node := self.protocol.gossip.nodes.get(link.zid)) is not None:
            if is_linked:
                return
            if connects_to(self.protocol.zid, node):
                self.meet(node)
            else:
                self.protocol.gossip.forget(link.zid)

    def _tell_fault(self, link: Link, why: str) -> None:
        """Say why a link was closed: of each reason the first time, and then each power of ten."""
        kind = ''.join(sign for sign in why if not sign.isdigit())
        if kind not in self._faults and len(self._faults) >= bounds.MOST_FAULTS:
            kind = ''
        self._faults[kind] += 1
        count = self._faults[kind]
        if is_told(count):
            times = '' if count == 1 else f' ({count} links by now for that reason)'
            self._warn(f'the link to {self._name_of(link)} was closed: {peer_text(why)}{times}')

    def _name_of(self, link: Link) -> str:
        return f'session {show_id(link.zid)}' if link.zid else 'an unknown session'

    def _warn(self, text: str) -> None:
        from goalwire.logging import get_logger  # needed only when something is broken

        get_logger(LOGGER).warning(f'Zenoh session {self.id}: {text}')

    def is_connected(self) -> bool:
        """Whether somebody has answered at one of the configured addresses, and the link is up."""
        return any(dial.is_up for dial in list(self._dials.values()) if dial.expected is None)

    def watch_links(self, on_link: Callable[[Link, str], None]) -> LinkWatch:
        """Tell of each link that is up or comes up, and the address that was dialled for it, if any."""
        watch = LinkWatch(self._watches, on_link)
        for link in self.protocol.links:
            on_link(link, self._address_of(link))
        return watch

    def _address_of(self, link: Link) -> str:
        dial = self._dialled.get(link)
        return '' if dial is None else dial.address

    # ---- times

    def call_later(self, seconds: float, function: Callable[[], None]) -> Timer:
        """Call a function later, on the thread that reads."""
        return self._poller.call_later(seconds, function)

    def expire_sooner(self) -> None:
        """A query's time is over earlier than any other's."""
        when = self.protocol.queries.next_timeout
        with self._lock:
            if when >= self._expiry:
                return
            timer = self._poller.call_later(when - monotonic(), self._expire)
            later, self._expiry_timer, self._expiry = self._expiry_timer, timer, when
        if later is not None:  # else each that fires would set another, and they become ever more
            later.cancel()

    def _expire(self) -> None:
        with self._lock:
            timer, self._expiry_timer, self._expiry = self._expiry_timer, None, float('inf')
        if timer is not None:
            timer.cancel()
        self.protocol.queries.expire()
        if self.protocol.queries.next_timeout != float('inf'):
            self.expire_sooner()

    def hold(self, outgoing: Outgoing) -> None:
        """Release soon what a link holds back."""
        self._flusher.hold(outgoing)

    def refuse(self, kind: str, reason: object) -> None:
        """Count something that came and is ignored."""
        self.rejects.add(kind, reason)

    def report(self, error: Exception) -> None:
        """Report what a user's function raised: it takes nobody else down."""
        report_failure(f'Zenoh session {self.id}', error)

    def note_change(self) -> None:
        """Have whoever waits for a link look again."""
        self.wake_all()

    # ---- blocking

    def wake_all(self) -> None:
        """Have whoever waits for a change look again."""
        for sleeper in list(self._sleepers):
            sleeper.wake()

    def wait_until(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Wait until links have come, gone or told all so that `condition` holds; False where not."""
        deadline = monotonic() + timeout_s
        sleeper = SleepingThread()
        self._sleepers.add(sleeper)
        try:
            while not condition():
                left = deadline - monotonic()
                if left <= 0:
                    return False
                self.wire_poller.wait(sleeper, int(min(left, 1e6) * 1e9))
            return True
        finally:
            self._sleepers.discard(sleeper)

    # ---- after a stop

    def note_running(self, now: float) -> None:
        """Take note that this process runs. If it has not for its lease, the others have closed their links.

        Then queries wait until these links are there again (`relink`), for RELINK_S from now at most.
        """
        protocol = self.protocol
        if now <= protocol.stale_after or protocol.stale_after == float('inf'):
            protocol.stale_after = now + self._settings.lease_ms / 1000
        elif self._relinking is None:
            self._relinking = self._poller.call_later(RELINK_S, self._believe_links)

    def _believe_links(self) -> None:
        relinking, self._relinking = self._relinking, None
        if relinking is not None:
            relinking.cancel()
        self._lost_asleep.clear()
        self.protocol.stale_after = monotonic() + self._settings.lease_ms / 1000
        self.wake_all()

    def relink(self) -> None:
        """Wait until the links are there again that have ended while this process was stopped.

        Called before a query after such a stop: what is sent over a link that the other side has closed is
        lost. A thread that reads, or changes the session's tables, does not wait.
        """
        if self.wire_poller.leads() or self.protocol.section.is_entered():
            return
        turns = 0

        def count_turn() -> None:
            nonlocal turns
            turns += 1
            if turns < READING_TURNS:
                self._poller.call(count_turn)
            else:
                self.wake_all()

        self.note_running(monotonic())
        self._poller.call(count_turn)
        self.wait_until(lambda: turns >= READING_TURNS, RELINK_S)
        self.wait_until(self._is_relinked, RELINK_S)
        self._believe_links()

    def _is_relinked(self) -> bool:
        return self._relinking is None or (
            all(map(self.protocol.is_linked, list(self._lost_asleep))) and self._has_settled()
        )

    def _wait_until_settled(self) -> None:
        """Wait until those that are to be met were met, and have told what they have."""
        goes_on_s = self._settings.connecting_s if self._must_connect else 0.0
        self.wait_until(self._has_settled, max(goes_on_s, CONNECTING_S))
        is_linked = self.protocol.is_linked
        others = [
            zid for zid, node in list(self.protocol.gossip.nodes.items()) if node.role is not Role.CLIENT
        ]
        if others and self._settings.meets_peers:
            self.wait_until(lambda: all(map(is_linked, others)) and self._has_settled(), OTHERS_S)
        if self._must_connect:
            self._check_connected()

    def _check_connected(self) -> None:
        """Raise TransportError where what must be reached was not."""
        missing = [dial for dial in list(self._dials.values()) if dial.expected is None and not dial.is_up]
        if missing:
            errors = ', '.join(dial.error for dial in missing if dial.error)
            is_client = self._settings.role is Role.CLIENT
            who = 'router' if is_client else 'peer or router'
            raise TransportError(
                f'cannot open a Zenoh session: no {who} answers at '
                f'{", ".join(address for dial in missing for address in dial.locators)}: {errors}; '
                f'{self._settings.advice}'
            )

    def _has_settled(self) -> bool:
        goes_on = self._must_connect and self._settings.connecting_s > 0
        tried = all(
            dial.is_connected or (dial.failed_rounds and not goes_on) for dial in list(self._dials.values())
        )
        return tried and all(link.is_up and link.peer.knows_all for link in list(self._links))

    def wait_for_room(self, socket_link: SocketLink, is_answer: bool) -> None:
        """Wait until a link has room; whoever reads does not wait, for reading is what makes room.

        A message may wait for ROOM_S. An answer waits only as long as whoever asked for it goes on reading.
        """
        if self.wire_poller.leads() or self.protocol.section.is_entered():
            return
        link = socket_link.link
        room, patience = (bounds.UNREAD_LIMIT, bounds.UNREAD_S) if is_answer else (QUEUE_LIMIT, ROOM_S)
        deadline, size = monotonic() + patience, link.outgoing.queue.size
        sleeper = SleepingThread()
        socket_link.waiting.add(sleeper)
        try:
            while link.outgoing.is_open and link.outgoing.queue.size > room:
                left = deadline - monotonic()
                if left <= 0 and is_answer and link.outgoing.queue.size <= size - bounds.PROGRESS:
                    deadline, size = monotonic() + patience, link.outgoing.queue.size
                elif left <= 0:
                    self._poller.call(partial(self._close_full, socket_link, patience))
                    return
                socket_link.watch_room()
                self.wire_poller.wait(sleeper, int(left * 1e9))
        finally:
            socket_link.waiting.discard(sleeper)

    def _close_full(self, socket_link: SocketLink, patience: float) -> None:
        socket_link.end(f'nothing was taken for {patience:g} s', UNRESPONSIVE, is_fault=True)

    # ---- the end

    def statistics(self) -> dict[str, int]:
        """Return how many messages found no room on the links there are."""
        return {'dropped': sum(link.outgoing.dropped for link in list(self._links))}

    def close(self) -> None:
        """Send what waits, tell the others, and let go of everything. Idempotent."""
        with self._lock:
            if self._is_closing:
                return
            self._is_closing = True
        if self.guard.is_forked:
            return
        self._look_ups.clear()
        for dial in list(self._dials.values()):
            dial.close()
        self._flusher.close()
        links = list(self._links.values())
        if any(each.link.outgoing.queue.size for each in links):
            self._flush(links)
        for each in links:
            each.end('the session is closed', GENERIC)
        self.wire_poller.close()
        self._is_closed = True
        for listener in self._listeners:
            self._poller.unregister(listener.fileno())
            listener.close()
        for each in list(self._links.values()):  # one that was taken at the last moment
            each.end('the session is closed', GENERIC)
        self._poller.close()

    def reset_in_child(self) -> None:
        """In a forked child: close its copies of the parent's sockets.

        Else the others would not notice when the parent ends, and its port would stay taken. The poller is
        closed first: nothing may change the epoll, which is the parent's too.
        """
        self._poller.close()
        for link in list(self._links.values()):
            link.close_socket()
        for dial in list(self._dials.values()):
            dial.close_socket()
        for listener in self._listeners:
            listener.close()

    def _flush(self, links: list[SocketLink]) -> None:
        """Wait until the others have taken what was sent, or for a while."""
        deadline = monotonic() + CLOSING_S
        sleeper = SleepingThread()
        for each in links:
            each.waiting.add(sleeper)
        while any(each.link.outgoing.is_open and each.link.outgoing.queue.size for each in links):
            left = deadline - monotonic()
            if left <= 0:
                return
            for each in links:
                each.watch_room()
            self.wire_poller.wait(sleeper, int(left * 1e9))
