"""A session: keeps its own declarations and those of its links in step, and tells its owner what to do.

As a peer it declares all its entities to every peer and router as soon as the link is up, and each change
from then on. It passes no messages on from one link to another: peers connect directly, and clients connect
to a router. A router only declares entities that it was asked for, so it is asked for all, once. A link that
has not sent all its declarations yet gets every message and every query. So no message is lost between the
start of a link and its declarations.

A message goes to the subscribers whose expression intersects its key, a query to the queryables whose
expression does. A complete queryable counts as complete for a query only if its expression also includes the
query's key. Messages and queries also reach the session's own entities, on the caller's thread.

All changes and copies of the tables are made in one critical section. If a signal's handler declares an
entity while its own thread is in the section, the entity is declared right after the thread has left.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import count
from typing import Protocol

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.channels import PieceBudget
from goalwire.zenoh.protocol.declarations import Declaration, Interest, Kind, final
from goalwire.zenoh.protocol.expressions import Expressions
from goalwire.zenoh.protocol.gossip import Gossip
from goalwire.zenoh.protocol.guard import Act
from goalwire.zenoh.protocol.handshake import Handshake, Identity
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.key_expressions import canonical, check
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.link_state import Node
from goalwire.zenoh.protocol.links import Links
from goalwire.zenoh.protocol.liveliness_tokens import Liveliness, Watcher
from goalwire.zenoh.protocol.outgoing import Connection
from goalwire.zenoh.protocol.own_entities import OwnEntities
from goalwire.zenoh.protocol.pending_queries import PendingQueries
from goalwire.zenoh.protocol.primitives import encode_replier, show_id
from goalwire.zenoh.protocol.queries import PendingQuery
from goalwire.zenoh.protocol.router_interests import RouterInterests
from goalwire.zenoh.protocol.routes import Queryable, Routes, Subscriber
from goalwire.zenoh.protocol.shared_memory import Pool
from goalwire.zenoh.protocol.stamps import Stamps

_DECLARES = {
    Kind.SUBSCRIBER: Act.DECLARE_SUBSCRIBER,
    Kind.QUERYABLE: Act.DECLARE_QUERYABLE,
    Kind.TOKEN: Act.DECLARE_TOKEN,
}


class SessionOwner(Protocol):
    """The owner of a session's sockets, as far as the session needs it. Only `relink` may block."""

    def meet(self, node: Node) -> None:
        """Connect to a node that a router has announced."""

    def welcome(self, link: Link) -> None:
        """Take note that a link is up, and that the session has declared everything on it."""

    def close_link(self, link: Link, why: str, reason: int) -> None:
        """Close a link soon, since a better one replaces it."""

    def note_change(self) -> None:
        """Take note that a link has come or gone, or has sent all its declarations."""

    def expire_sooner(self) -> None:
        """Set the timer anew: `PendingQueries.next_timeout` has become earlier."""

    def refuse(self, kind: str, reason: object) -> None:
        """Count an ignored message, by its kind and the reason."""

    def relink(self) -> None:
        """Wait for links that may have ended unnoticed. Called before a query after `stale_after`."""

    def report(self, error: Exception) -> None:
        """Log what a user's function raised. The session goes on."""


class SessionProtocol:
    """One session: declares entities for its user, and keeps the declarations of all links."""

    def __init__(
        self,
        identity: Identity,
        owner: SessionOwner,
        *,
        clock: Callable[[], float],
        wall_clock_ns: Callable[[], int],
    ) -> None:
        """`clock` returns s for timeouts, `wall_clock_ns` the time for timestamps."""
        self.identity = identity
        self.zid = identity.zid
        self.id = show_id(identity.zid)
        self.clock = clock
        self.stale_after = float('inf')
        """The time, on `clock`, until which a link that seems alive is trusted.

        The owner of the sockets moves it forward while this process runs.
        """
        self.memory: Pool | None = None
        """The memory for publishing large payloads; set by the owner."""
        self.relink = owner.relink
        self.refuse = owner.refuse
        self.report = owner.report
        self.section = CriticalSection()
        self.pieces = PieceBudget(bounds.UNFINISHED_LIMIT)
        self.stamps = Stamps(identity.zid, wall_clock_ns)
        self.stamp: Callable[[], bytes] = self.stamps.next
        """Returns an encoded timestamp later than any before it."""
        self.expressions = Expressions()
        self.own_keys = self.expressions.keys
        self.queries = PendingQueries(clock, owner.expire_sooner, owner.report)
        links = Links(self.zid, owner.close_link)
        self.routes = Routes(self.section, links, self.zid, owner.refuse, owner.report)
        self.gossip = Gossip(identity, links, owner.meet, owner.refuse)
        self.next_number = count(1).__next__
        self.interests = RouterInterests(links, self.next_number)
        """The entities that routers are asked for; the keys are set before the first link."""
        self._owner = owner
        self._links = links
        self._liveliness = Liveliness(owner.report)
        self._entities = OwnEntities(links, self.expressions, self.routes, self._liveliness)

    @property
    def links(self) -> tuple[Link, ...]:
        """The links that are up."""
        return self._links.up

    def is_linked(self, zid: bytes) -> bool:
        """Return whether there is a link to a session."""
        return self._links.is_linked(zid)

    # ---- what its user declares

    def declare_subscriber(
        self,
        key: str,
        callback: Callable[[Sample], None],
        *,
        takes_own: bool = True,
        takes_views: bool = False,
    ) -> int:
        """Call `callback` with each message whose key intersects `key`; return a number for `undeclare`.

        With `takes_views` a payload in shared memory may stay there: then it is a memoryview, and the memory
        is not reused while the view lives.
        """
        key = canonical(key)
        number = self.next_number()
        subscriber = Subscriber(callback, takes_own, takes_views)
        self.section.run(partial(self._entities.add_subscriber, number, key, subscriber))
        return number

    def declare_queryable(self, key: str, callback: Callable[[Query], None], *, complete: bool) -> int:
        """Call `callback` with each query for this key. The user must end each query, at any time."""
        key = canonical(key)
        number = self.next_number()
        queryable = Queryable(callback, complete, encode_replier(self.zid, number))
        self.section.run(partial(self._entities.add_queryable, number, key, queryable))
        return number

    def declare_token(self, key: str) -> int:
        """Declare a token: a key that all watchers see."""
        check(key)
        number = self.next_number()
        self.section.run(partial(self._entities.add_token, number, key))
        self._liveliness.tell()
        return number

    def watch_tokens(self, key: str, callback: Watcher, *, history: bool, own_only: bool = False) -> int:
        """Report tokens that come and go; with `history` also the existing tokens, before this returns.

        With `own_only` the key matches this session's tokens alone. Routers are not asked for them then: they
        would compare each token with this session's question and never have an answer.
        """
        key = canonical(key)
        number = self.next_number()
        if self.interests.is_narrow and not own_only:
            self.section.run(partial(self.interests.add_token_key, key))
        self.section.run(partial(self._liveliness.watch, number, key, callback, history=history))
        self._liveliness.tell()
        return number

    def tokens(self, key: str) -> list[str]:
        """Return the existing tokens that match `key`."""
        with self.section.lock:
            return self._liveliness.present(canonical(key))

    def undeclare(self, number: int) -> None:
        """Undeclare an entity or a watcher. An unknown number is not an error."""

        def take_back() -> None:
            if not self._entities.remove(number):
                self._liveliness.unwatch(number)

        self.section.run(take_back)
        self._liveliness.tell()

    def use_key(self, key: str) -> None:
        """Give a key a number, which it keeps until `Expressions.discard` was called as often as this."""
        self.section.run(partial(self.expressions.use, key))
        if self.interests.is_narrow:
            self.section.run(partial(self.interests.add_entity_key, key))
            self.routes.note_change()

    # ---- links come and go

    def make_link(self, handshake: Handshake, connection: Connection, *, lease_ms: int) -> Link:
        """Return the link of a new connection."""
        return Link(self, handshake, connection, lease_ms=lease_ms)

    def take_link(self, link: Link) -> None:
        """Declare everything on a new link, and ask a router for what it has."""
        self.section.run(partial(self._greet, link))
        # The owner is called outside the section, since it may call users' functions.
        self._owner.note_change()
        self._owner.welcome(link)

    def _greet(self, link: Link) -> None:
        self._links.add(link)
        out: list[bytes] = []
        if link.role is Role.ROUTER:
            out.append(self.gossip.introduce())
        # A client declares its entities, and asks for others by INTEREST. Peers tell each other everything
        # unasked and end with a final. A router must be asked.
        if link.role is Role.CLIENT:
            link.peer.knows_all = True
        else:
            out += self._entities.tell_all(link)
            if link.role is Role.PEER and self.identity.role is Role.PEER:
                out.append(final())
            else:
                out += self.interests.ask_all(link)
        link.outgoing.declare(*out)
        # Senders must look up their links again: the new link gets all messages until it has declared its
        # own.
        self.routes.forget()

    def lose_link(self, link: Link) -> None:
        """Forget what an ended link had declared, and stop waiting for answers from it. Idempotent."""
        ended: list[PendingQuery] = []
        self.section.run(partial(self._let_go, link, ended))
        self._liveliness.tell()
        # Users' functions run outside the section, when all tables are consistent.
        for query in ended:
            self.queries.end(query)
        self._owner.note_change()

    def _let_go(self, link: Link, ended: list[PendingQuery]) -> None:
        if link.is_lost:
            return
        link.is_lost = True
        self._links.remove(link)
        # Declarations end with their link. Tokens are counted, since another link may declare the same key.
        for key in link.peer.tokens.values():
            self._liveliness.vanished(key)
        link.peer.tokens.clear()
        self.routes.forget()
        ended += self.queries.remove_asked(link)

    # ---- what links report

    def take_declaration(self, link: Link, declaration: Declaration) -> None:
        """Take a declaration, or an undeclaration, of a link's other side."""
        self.section.run(partial(self._note_declaration, link, declaration))
        kind = declaration.kind
        if kind is Kind.TOKEN:
            self._liveliness.tell()
        elif kind is Kind.FINAL:
            self._owner.note_change()

    def _note_declaration(self, link: Link, declaration: Declaration) -> None:
        peer = link.peer
        if declaration.kind is Kind.FINAL:
            # From now on the link gets only the messages and queries that match its declarations.
            peer.awaited.discard(declaration.interest or 0)
            if not peer.knows_all and not peer.awaited:
                peer.knows_all = True
                self.routes.forget()
        elif declaration.undeclares:
            self._remove_declared(link, declaration.kind, declaration.number)
        else:
            key = peer.key_of(declaration.scope, declaration.suffix, declaration.is_senders)
            if key is not None:
                self._add_declared(link, declaration, check(key))

    def _add_declared(self, link: Link, declaration: Declaration, key: str) -> None:
        kind, number = declaration.kind, declaration.number
        if kind is Kind.EXPRESSION:
            if link.peer.add_expression(number, key):
                link.forget_receivers()
        elif not number and declaration.interest is not None:
            return  # not kept: it answers an interest in present entities, so its end is never declared
        elif link.refusal(_DECLARES[kind], key):
            return
        elif kind is Kind.TOKEN:
            if link.peer.add_token(number, key):
                self._liveliness.appeared(key)
        else:
            link.peer.add_entity(declaration, key)
            self.routes.note_change()

    def _remove_declared(self, link: Link, kind: Kind, number: int) -> None:
        """Forget an undeclared entity. A number without a key also invalidates the receivers found by it."""
        if kind is Kind.EXPRESSION:
            if link.peer.remove_expression(number):
                self.routes.forget()
        elif kind is Kind.TOKEN:
            token = link.peer.remove_token(number)
            if token is not None:
                self._liveliness.vanished(token)
        else:
            link.peer.remove_entity(kind, number)
            self.routes.note_change()

    def take_interest(self, link: Link, wish: Interest) -> None:
        """Answer a client's interest."""
        link.check_reads()
        self.section.run(partial(self._entities.take_interest, link, wish))

    def take_nodes(self, link: Link, nodes: list[Node]) -> None:
        """Take note of nodes that a router announces."""
        self.gossip.take(link, nodes)
