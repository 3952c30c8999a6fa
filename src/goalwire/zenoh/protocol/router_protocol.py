"""A router for one machine: it introduces peers to each other, and serves clients.

Once they have met, peers talk over links of their own. So a router passes on only traffic from and to
clients: declarations, to the links that have asked for them, messages, queries and their replies. It does not
connect to other routers, and has no subscribers or queryables of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.declarations import Declaration, Interest, Kind
from goalwire.zenoh.protocol.handshake import Handshake, Identity
from goalwire.zenoh.protocol.introductions import Introductions
from goalwire.zenoh.protocol.key_expressions import includes
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.link_state import Node
from goalwire.zenoh.protocol.network import BLOCK, Target, response_final
from goalwire.zenoh.protocol.outgoing import Connection
from goalwire.zenoh.protocol.queries import PendingQuery
from goalwire.zenoh.protocol.relayed_entities import RelayedEntities
from goalwire.zenoh.protocol.router_link import Passing, RouterLink
from goalwire.zenoh.protocol.session_protocol import SessionOwner, SessionProtocol

FORGOTTEN_S = 600.0
"""How long an unanswered query is remembered: rmw_zenoh's limit. The asking side has its own timeout."""


def _send_final(link: Link, request: int, message: Passing) -> None:
    """Tell the link that has asked that there are no more replies."""
    link.outgoing.send(message.channel, response_final(request, message.qos))


class PassedQuery(PendingQuery):
    """A query that was passed on; `request` is its number on the link that `asked`."""

    __slots__ = ('asked', 'request')

    def __init__(
        self, asked: Link, request: int, message: Passing, left: list[object], deadline: float
    ) -> None:
        self.asked = asked
        self.request = request
        super().__init__(
            message.key,
            b'',
            left,
            deadline,
            lambda _: None,  # replies are passed on as bytes
            lambda: _send_final(asked, request, message),
            takes_any_key=True,
        )


class RouterProtocol(SessionProtocol):
    """A session in the role of a router."""

    def __init__(
        self,
        identity: Identity,
        owner: SessionOwner,
        *,
        clock: Callable[[], float],
        wall_clock_ns: Callable[[], int],
        passes_on: bool = True,
    ) -> None:
        """With `passes_on` False, it only introduces peers to each other, and clients reach nobody."""
        super().__init__(identity, owner, clock=clock, wall_clock_ns=wall_clock_ns)
        self._relayed = RelayedEntities(self._links, passes_on=passes_on)
        self._introductions = Introductions(self._links)

    def make_link(self, handshake: Handshake, connection: Connection, *, lease_ms: int) -> Link:
        """Return the link of a new connection."""
        return RouterLink(self, handshake, connection, lease_ms=lease_ms)

    # ---- links come and go

    def _greet(self, link: Link) -> None:
        self._links.add(link)
        link.peer.knows_all = True
        if link.role is not Role.CLIENT:
            link.outgoing.declare(self.gossip.introduce(), *self._introductions.tell_all())

    def _let_go(self, link: Link, ended: list[PendingQuery]) -> None:
        if link.is_lost:
            return
        super()._let_go(link, ended)
        self._introductions.forget(link.zid)
        self._relayed.remove_link(link)
        # No link waits any more for the answers to this link's queries.
        for number, query in list(self.queries.pending.items()):
            if isinstance(query, PassedQuery) and query.asked is link:
                self.queries.cancel(number)

    def take_nodes(self, link: Link, nodes: list[Node]) -> None:
        """Introduce a peer to the other peers."""
        self.section.run(partial(self._introductions.take, link, nodes))

    # ---- declarations

    def _add_declared(self, link: Link, declaration: Declaration, key: str) -> None:
        """Keep an entity, and relay it if it was kept: it may be refused, or beyond the bounds."""
        kind, number = declaration.kind, declaration.number
        is_refused = kind is Kind.TOKEN and link.peer.has(kind, number)
        super()._add_declared(link, declaration, key)
        if kind is not Kind.EXPRESSION and not is_refused and link.peer.has(kind, number):
            self._relayed.add(link, declaration, key)

    def _remove_declared(self, link: Link, kind: Kind, number: int) -> None:
        super()._remove_declared(link, kind, number)
        self._relayed.remove(link, kind, number)

    def take_interest(self, link: Link, wish: Interest) -> None:
        """Answer the interest of a peer or a client."""
        link.check_reads()
        self.section.run(partial(self._relayed.take_interest, link, wish))

    # ---- messages, queries and replies

    def pass_put(self, link: Link, message: Passing) -> None:
        """Pass a message on to each link with a subscriber.

        A message that may not be dropped waits for a slow client, but is dropped, too, above a bound.
        """
        receivers: list[Link] = []

        def find() -> None:
            others = self._relayed.others(link)
            receivers.extend(each for each in others if each.peer.subscribers.has_meeting(message.key))

        self.section.run(find)
        encoded = message.encode() if receivers else b''
        for each in receivers:
            outgoing = each.outgoing
            may_drop = not message.qos & BLOCK or outgoing.queue.size > bounds.UNREAD_LIMIT
            outgoing.send(message.channel, encoded, droppable=may_drop)

    def pass_query(self, link: Link, request: int, target: int, message: Passing) -> None:
        """Pass a query on to each link with a queryable for it. If there is none, end the query at once."""
        link.check_reads()
        asked: list[Link] = []
        self.section.run(lambda: asked.extend(self._answerers(link, target, message.key)))
        if not asked:
            _send_final(link, request, message)
            return
        deadline = self.clock() + FORGOTTEN_S
        # The query gets a number of this router's, since two askers may use the same number.
        number = self.queries.add(PassedQuery(link, request, message, list(asked), deadline))
        encoded = message.encode(number)
        for each in asked:
            if not each.outgoing.send(message.channel, encoded):
                self.queries.take_final(each, number)

    def _answerers(self, link: Link, target: int, key: str) -> list[Link]:
        """Return the links that a query goes to: all with a queryable, the complete ones, or the best one."""
        found: list[Link] = []
        complete: list[Link] = []
        for each in self._relayed.others(link) if key else ():
            meeting = each.peer.queryables.meeting(key)
            if meeting:
                found.append(each)
            if any(is_complete and includes(expression, key) for expression, (is_complete, _) in meeting):
                complete.append(each)
        if target == Target.ALL_COMPLETE:
            return complete
        return complete[:1] if complete and target == Target.BEST_MATCHING else found

    def pass_reply(self, link: Link, request: int, message: Passing) -> None:
        """Pass a reply on to the link that has asked, if that link still waits."""
        query = self.queries.find(link, request)
        if isinstance(query, PassedQuery):
            query.asked.outgoing.send(message.channel, message.encode(query.request), is_answer=True)
