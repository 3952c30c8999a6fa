"""A session: its links, the threads that wait on them, and its end."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable, Sequence
from threading import RLock
from time import monotonic, time_ns

from goalwire.concurrency.blocked_calls import BlockedCalls
from goalwire.concurrency.forks import ForkGuard, open_privately
from goalwire.concurrency.leader_followers import LeaderFollowers
from goalwire.concurrency.poller import Poller, Timer
from goalwire.errors import TransportError
from goalwire.fault_reports import RejectCounters, report_failure
from goalwire.zenoh.io.backpressure import Backpressure
from goalwire.zenoh.io.dialler import Dial
from goalwire.zenoh.io.dials import Dials
from goalwire.zenoh.io.endpoints import parse
from goalwire.zenoh.io.fault_log import FaultLog
from goalwire.zenoh.io.flusher import Flusher
from goalwire.zenoh.io.link_maker import LinkMaker
from goalwire.zenoh.io.listeners import Listeners
from goalwire.zenoh.io.query_timer import QueryTimer
from goalwire.zenoh.io.settings import Settings
from goalwire.zenoh.io.shared_memory.session_memory import SessionMemory
from goalwire.zenoh.io.socket_link import SocketLink
from goalwire.zenoh.io.suspension import Relinking
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.handshake import Handshake, Identity
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.link_state import Node
from goalwire.zenoh.protocol.primitives import GENERIC
from goalwire.zenoh.protocol.session_protocol import SessionProtocol

CONNECTING_S = 1.0
"""How long opening waits for an address that neither accepts nor refuses."""
OTHERS_S = 0.1
"""How long opening waits for nodes that will connect to this session."""
CLOSING_S = 1.0
"""How long closing waits for the others to read the last messages."""


def _most_descriptors() -> int:
    """Return how many files and sockets this process may have open."""
    try:
        import resource
    except ImportError:  # Windows
        return 2 * bounds.MOST_LINKS
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return most if most != resource.RLIM_INFINITY else 2 * bounds.MOST_LINKS


def _explain_missing(missing: Sequence[Dial], settings: Settings) -> str:
    """Return an error text: the addresses that do not answer, and the user's remedies."""
    errors = ', '.join(dial.error for dial in missing if dial.error)
    who = 'router' if settings.role is Role.CLIENT else 'peer or router'
    where = ', '.join(address for dial in missing for address in dial.locators)
    return f'cannot open a Zenoh session: no {who} answers at {where}: {errors}; {settings.advice}'


class LinkWatch:
    """Calls a function for each link that comes up."""

    def __init__(self, watches: set[LinkWatch], on_link: Callable[[Link, str], None]) -> None:
        self.on_link = on_link
        self._watches = watches
        watches.add(self)

    def undeclare(self) -> None:
        """Stop calling the function."""
        self._watches.discard(self)


class NativeSession:
    """One open session. `protocol` declares, publishes and queries; idle threads may wait in `wire_poller`.

    It owns the protocol and the sockets, and serves both as their `SessionOwner` and `SocketLinkOwner`.
    """

    def __init__(self, settings: Settings) -> None:
        """Open the session; wait for the declarations of the nodes it connects to. Raises TransportError."""
        zid = settings.zid or os.urandom(15) + bytes((1 + os.urandom(1)[0] % 255,))
        self.guard = ForkGuard()
        self.rejects = RejectCounters()
        """Counts the messages of peers that this session ignored, by kind."""
        self.lease_ms = settings.lease_ms
        self.protocol = protocol = self._make_protocol(
            Identity(zid, settings.role, settings.lease_ms), settings
        )
        protocol.interests.token_keys += settings.token_keys
        if settings.entity_keys is not None:
            protocol.interests.entity_keys = list(settings.entity_keys)
        self.id = protocol.id
        name = f'goalwire-zenoh {self.id[:8]}'
        self._settings = settings
        self._memory = protocol.memory = SessionMemory(settings.memory, self.id, self.guard)
        self._flusher = Flusher(f'{name} flusher')
        self.hold = self._flusher.hold
        self._poller = poller = open_privately(
            lambda: Poller(
                f'Zenoh session {self.id}',
                portable=settings.portable,
                before_sleep=(self._flusher.held, self._flusher.flush),
                awaited=protocol.queries.pending,
            )
        )
        self.wire_poller = LeaderFollowers(poller, name)
        self._blocked_calls = BlockedCalls(self.wire_poller)
        self._backpressure = Backpressure(self.wire_poller, protocol.section, poller)
        self._query_timer = QueryTimer(poller)
        self._faults = FaultLog(self.id)
        self._maker = LinkMaker(self, poller, settings.tls, settings.identify)
        self._listeners = Listeners(poller, self._take_inbound, self._faults.warn)
        self._dials = Dials(
            poller, protocol.gossip, protocol.zid, self._take_outbound, self._blocked_calls.wake_all
        )
        self._relinking = Relinking(
            protocol, poller, self._blocked_calls, self._has_settled, settings.lease_ms / 1000
        )
        self._lock = RLock()
        self._links: dict[Link, SocketLink] = {}
        self._greetings: dict[Link, SocketLink] = {}
        """Links that others have opened and that are in their handshake."""
        self._most_links = min(bounds.MOST_LINKS, _most_descriptors() // 2)
        self._watches: set[LinkWatch] = set()
        self._is_closing = False
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    # ---- opening

    def _make_protocol(self, identity: Identity, settings: Settings) -> SessionProtocol:
        if identity.role is not Role.ROUTER:
            return SessionProtocol(identity, self, clock=monotonic, wall_clock_ns=time_ns)
        # imported here, since only one process of a machine is its router
        from goalwire.zenoh.protocol.router_protocol import RouterProtocol

        return RouterProtocol(
            identity, self, clock=monotonic, wall_clock_ns=time_ns, passes_on=settings.passes_on
        )

    def _open(self) -> None:
        settings = self._settings
        for each in settings.listen:
            endpoint = parse(each)
            self._maker.check_listening(endpoint)
            self.protocol.gossip.locators += tuple(self._listeners.listen(endpoint, each))
        self.wire_poller.start()
        for each in settings.connect:
            self._maker.check_dialling(parse(each))
        is_client = settings.role is Role.CLIENT
        # A client needs one router of the configured ones; a peer connects to each.
        groups = [settings.connect] if is_client else [(each,) for each in settings.connect]
        self._dials.start([each for each in groups if each], settings.retry, settings.open_s)
        self._wait_until_settled()

    def _wait_until_settled(self) -> None:
        """Wait until the nodes to connect to are linked, and have sent all their declarations."""
        must_connect = self._settings.fails_unconnected
        goes_on_s = self._settings.connecting_s if must_connect else 0.0
        self.wait_until(self._has_settled, max(goes_on_s, CONNECTING_S))
        is_linked = self.protocol.is_linked
        nodes = list(self.protocol.gossip.nodes.items())
        others = [zid for zid, node in nodes if node.role is not Role.CLIENT]
        if others and self._settings.meets_peers:
            self.wait_until(lambda: all(map(is_linked, others)) and self._has_settled(), OTHERS_S)
        if must_connect and (missing := self._dials.missing()):
            raise TransportError(_explain_missing(missing, self._settings))

    def _has_settled(self) -> bool:
        goes_on = self._settings.fails_unconnected and self._settings.connecting_s > 0
        tried = self._dials.have_settled(go_on=goes_on)
        return tried and all(link.is_up and link.peer.knows_all for link in list(self._links))

    # ---- connections come and go

    def _take_inbound(self, sock: socket.socket, protocol: str) -> None:
        """Take a connection that another side has opened, if there is room for it."""
        if len(self._links) >= self._most_links:
            self.refuse('connection', f'there are {self._most_links} links')
            sock.close()
            return
        if len(self._greetings) >= bounds.MOST_GREETINGS:
            oldest = next(iter(self._greetings.values()))
            self.refuse('connection', f'{bounds.MOST_GREETINGS} newer ones are in their handshake')
            oldest.end('others wait')
        try:
            new = self._maker.make_inbound(sock, protocol, self._handshake(sock, protocol))
            self._links[new.link] = self._greetings[new.link] = new
        # A signal's handler may raise here. No other code knows the socket yet, and its other end waits.
        except BaseException:
            sock.close()
            raise
        new.start()

    def _take_outbound(self, dial: Dial, sock: socket.socket) -> None:
        """Take a connection that this side has opened."""
        if self._is_closing:
            sock.close()
            return
        try:
            endpoint = parse(dial.address)
            new = self._maker.make_outbound(sock, endpoint, self._handshake(sock, endpoint.protocol, dial))
            self._links[new.link] = new
        except BaseException:  # as in _take_inbound
            sock.close()
            raise
        self._dials.keep(dial, new.link)
        new.start(dial.handshake_s)

    def _handshake(self, sock: socket.socket, protocol: str, dial: Dial | None = None) -> Handshake:
        return Handshake(
            self.protocol.identity,
            connects=dial is not None,
            random=os.urandom,
            expected=None if dial is None else dial.expected,
            is_linked=self._is_met,
            memory=self._memory.agreement(sock, protocol),
        )

    def _is_met(self, zid: bytes) -> bool:
        """True if a session is linked, or if this side has dialled it and is in the handshake.

        This prevents two sessions that dial each other at once from ending up with two links: eclipse-zenoh
        (1.10.2) may send nothing more over the link that stays.
        """
        return self.protocol.is_linked(zid) or self._dials.is_shaking_hands(zid)

    def take_end(self, socket_link: SocketLink, why: str, is_fault: bool) -> None:
        """Take note that a connection has ended; connect again, if this side is the one that dials."""
        link = socket_link.link
        self._links.pop(link, None)
        self._greetings.pop(link, None)
        # Before `lose_link` ends the queries: a caller who asks again at once then waits for the new link.
        self._relinking.note_lost(link.zid)
        if is_fault and not self._is_closing:
            self._faults.tell(link, why)
        self.protocol.lose_link(link)
        socket_link.wake_waiting()
        self._blocked_calls.wake_all()
        dial = self._dials.forget(link)
        if self._is_closing:
            return
        # The session at the other end may still be linked, by a link that has replaced this one.
        is_linked = bool(link.zid) and self.protocol.is_linked(link.zid)
        if dial is not None:
            late = socket_link.took_too_long
            self._dials.dial_again(dial, link, why, is_linked=is_linked, took_too_long=late)
        elif link.terms is not None and not is_linked:
            node = self._dials.node_to_meet(link.zid)
            if node is not None:
                self.meet(node)

    def note_running(self, now: float) -> None:
        """Take note that this process runs. A long gap since the last call shows a stop; `now` in s."""
        self._relinking.note_running(now)

    def wait_for_room(self, socket_link: SocketLink, is_answer: bool) -> None:
        """Block until fewer bytes wait for a connection, if this thread may block."""
        self._backpressure.wait_for_room(socket_link, is_answer)

    # ---- what the protocol asks for

    def meet(self, node: Node) -> None:
        """Connect to a node that a router has announced. Only the thread that reads calls this."""
        if not self._settings.meets_peers or self._is_closing or self._dials.is_meeting(node.zid):
            return
        # gossip is not trusted: it must not lead to a link without TLS
        if self._settings.identify is not None:
            safe = tuple(each for each in node.locators if each.startswith('tls/'))
            node = Node(node.zid, node.role, safe)
        if len(self._links) >= self._most_links:
            self.refuse('node of gossip', f'there are {self._most_links} links')
            self.protocol.gossip.forget(node.zid)
        else:
            self._dials.meet(node)

    def welcome(self, link: Link) -> None:
        """Take note that a link is up. Another thread may have closed the session and the link already."""
        self._greetings.pop(link, None)
        socket_link = self._links.get(link)
        if socket_link is None:
            return
        self._dials.note_up(link)
        socket_link.came_up()
        self._relinking.note_running(monotonic())
        for watch in list(self._watches):
            watch.on_link(link, self._dials.address_of(link))

    def close_link(self, link: Link, why: str, reason: int) -> None:
        """Close a link soon."""

        def close() -> None:
            socket_link = self._links.get(link)
            if socket_link is not None:
                socket_link.end(why, reason)

        self._poller.call(close)

    def note_change(self) -> None:
        """Wake the threads that wait for a link, so that they look again."""
        self._blocked_calls.wake_all()

    def expire_sooner(self) -> None:
        """Set the timer for the earliest timeout of a query."""
        self._query_timer.set_for(self.protocol.queries)

    def refuse(self, kind: str, reason: object) -> None:
        """Count a received message that is ignored."""
        self.rejects.add(kind, reason)

    def relink(self) -> None:
        """Wait until links that the peers may have closed unnoticed are back, if this thread may wait."""
        if self._backpressure.may_block():
            self._relinking.wait()

    def report(self, error: Exception) -> None:
        """Log what a user's function raised. The session goes on."""
        report_failure(f'Zenoh session {self.id}', error)

    # ---- what its user asks for

    def is_connected(self) -> bool:
        """True if the link to at least one of the configured addresses is up."""
        return self._dials.is_connected()

    def watch_links(self, on_link: Callable[[Link, str], None]) -> LinkWatch:
        """Call `on_link` with each link that is up or comes up, and its dialled address ('' if none)."""
        watch = LinkWatch(self._watches, on_link)
        for link in self.protocol.links:
            on_link(link, self._dials.address_of(link))
        return watch

    def call_later(self, seconds: float, function: Callable[[], None]) -> Timer:
        """Call a function after some seconds, on the thread that reads."""
        return self._poller.call_later(seconds, function)

    def wait_until(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Wait until `condition` holds, checking it at each change of a link; False after the timeout."""
        return self._blocked_calls.wait_until(condition, timeout_s)

    def statistics(self) -> dict[str, int]:
        """Return how many messages the present links have dropped for lack of room."""
        return {'dropped': sum(link.outgoing.dropped for link in list(self._links))}

    # ---- the end

    def close(self) -> None:
        """Send the queued messages, tell the other sides, and close everything. Idempotent."""
        with self._lock:
            if self._is_closing:
                return
            self._is_closing = True
        if self.guard.is_forked:
            return
        # First no new connections come, then the queued messages go out, then the links are closed.
        self._listeners.stop()
        self._dials.close()
        self._flusher.close()
        links = list(self._links.values())
        if any(each.outgoing.queue.size for each in links):
            self._backpressure.drain(links, CLOSING_S)
        for each in links:
            each.end('the session is closed', GENERIC)
        self.wire_poller.close()
        self._listeners.close()
        for each in list(self._links.values()):  # links accepted while the others were closed
            each.end('the session is closed', GENERIC)
        self._poller.close()
        self._memory.close()
