"""A session: its own declarations, those of its links, and the routing of messages between them.

As a peer it tells every peer and router all that it has as soon as the link is up, and each change from then
on. It passes nothing on from one link to another: peers connect directly, and clients connect to a router. A
router tells only what it was asked for, so it is asked for everything, once. A link that has not told all yet
gets every message and every query. So nothing is lost between the link and its declarations.

A put goes to the subscribers whose expression intersects its key, and a query to such queryables. A queryable
that is declared complete counts as complete for a query only if it also includes the query's key. What is put
or asked here is also delivered here, on the caller's thread.

What changes or copies the tables does so in one critical section: what a signal's handler declares while its
own thread is just at it is declared right after that.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import count
from typing import NamedTuple

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.reports import report_failure
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.channels import PieceBudget
from goalwire.zenoh.protocol.declarations import (
    About,
    Declaration,
    Interest,
    Kind,
    When,
    declare,
    final,
    interest,
    take_back,
)
from goalwire.zenoh.protocol.expressions import Expressions
from goalwire.zenoh.protocol.handshake import Identity
from goalwire.zenoh.protocol.key_expressions import canonical, check, intersects
from goalwire.zenoh.protocol.key_index import KeyIndex, is_odd
from goalwire.zenoh.protocol.link import Link, Receivers
from goalwire.zenoh.protocol.link_state import Node, connects_to, tell_of
from goalwire.zenoh.protocol.liveliness import Liveliness, Watcher
from goalwire.zenoh.protocol.network import (
    QueryMessage,
    Sample,
    response_final,
    wire_key,
)
from goalwire.zenoh.protocol.primitives import (
    MAX_LINKS,
    UNRESPONSIVE,
    ZenohProtocolError,
    decode_source,
    encode_replier,
    show_id,
)
from goalwire.zenoh.protocol.queries import TIMEOUT, Answer, PendingQuery, Query, RemoteQuery
from goalwire.zenoh.protocol.stamps import Stamps
from goalwire.zenoh.protocol.transport import Role

_ABOUT = {Kind.SUBSCRIBER: About.SUBSCRIBERS, Kind.QUERYABLE: About.QUERYABLES, Kind.TOKEN: About.TOKENS}


class Subscriber(NamedTuple):
    """A subscriber of this session's."""

    callback: Callable[[Sample], None]
    takes_own: bool


class Queryable(NamedTuple):
    """A queryable of this session's."""

    callback: Callable[[Query], None]
    complete: bool
    replier: bytes


class Answerers(NamedTuple):
    """The queryables that answer what a link asks on one of its keys."""

    key: str
    queryables: tuple[Queryable, ...]


_NOBODY = Receivers('', ())


class SessionProtocol:
    """One session's tables, and what changes them."""

    def __init__(
        self,
        identity: Identity,
        *,
        clock: Callable[[], float],
        wall_clock_ns: Callable[[], int],
        when_told: Callable[[Node], None] = lambda _: None,
        when_changed: Callable[[], None] = lambda: None,
        when_sooner: Callable[[], None] = lambda: None,
        close_link: Callable[[Link, str, int], None] = lambda *_: None,
        when_refused: Callable[[str, object], object] = lambda *_: None,
        when_stale: Callable[[], None] = lambda: None,
    ) -> None:
        """`clock` tells s for timeouts. `when_told` gets nodes to connect to, `when_changed` is called when a
        link has come, gone or told all, `when_sooner` when `next_timeout` is nearer than it was, `close_link`
        with a link that a better one replaces, and that is to be closed soon, `when_refused` with the kind of
        what was ignored, and why. None of them may block.
        `when_stale` is called before a query that is sent later than `stale_after`, and may block."""
        self.identity = identity
        self.zid = identity.zid
        self.id = show_id(identity.zid)
        self.locators: tuple[str, ...] = ()
        """Where this session listens; set before the first link."""
        self.section = CriticalSection()
        self.version = 0
        """Counts the changes of receivers."""
        self.links: tuple[Link, ...] = ()
        """Those that are up."""
        self.expressions = Expressions()
        self.subscribers: KeyIndex[Subscriber] = KeyIndex()
        self.queryables: KeyIndex[Queryable] = KeyIndex()
        self.pending: dict[int, PendingQuery] = {}
        self.nodes: dict[bytes, Node] = {}
        """The nodes of which routers told."""
        self.liveliness = Liveliness(self.callback_failed)
        self.stale_after = float('inf')
        """Until when a link that looks alive is believed; on `clock`.

        Whoever does the input and output moves it on while this process runs.
        """
        self.when_stale = when_stale
        self.next_timeout = float('inf')
        """When a query's time is over, or before: `expire` is to be called then."""
        self.clock = clock
        self.stamps = Stamps(identity.zid, wall_clock_ns)
        self.stamp: Callable[[], bytes] = self.stamps.next
        """Returns a timestamp later than any before it, as the wire has it."""
        self.next_number = count(1).__next__
        self._next_request = count(1).__next__
        self._when_told = when_told
        self._when_changed = when_changed
        self._when_sooner = when_sooner
        self._close_link = close_link
        self._when_refused = when_refused
        self.pieces = PieceBudget(bounds.UNFINISHED_LIMIT)
        self._tokens: dict[int, str] = {}
        self._answerers: dict[tuple[Link, int, bytes, int], Answerers] = {}
        self._changes = 0

    # ---- times

    def expire(self) -> None:
        """End the queries whose time is over."""
        now = self.clock()
        over = [request for request, query in list(self.pending.items()) if query.deadline <= now]
        ended = [query for query in (self.pending.pop(each, None) for each in over) if query is not None]
        # First none, then the least: what is asked meanwhile, on any thread, is earlier than none.
        self.next_timeout = float('inf')
        earliest = min((query.deadline for query in list(self.pending.values())), default=float('inf'))
        self.next_timeout = min(self.next_timeout, earliest)
        for query in ended:
            for _ in query.left:
                self._reply(query, TIMEOUT)
            query.left.clear()
            self._end(query)

    # ---- declaring

    def declare_subscriber(
        self, key: str, callback: Callable[[Sample], None], *, takes_own: bool = True
    ) -> int:
        """Call `callback` with each message whose key meets this one; return what to `undeclare`."""
        key = canonical(key)
        number = self.next_number()

        def declare() -> None:
            self.subscribers.add(number, key, Subscriber(callback, takes_own))
            self.expressions.use(key)
            self._forget_routes()
            self._tell_links(Kind.SUBSCRIBER, number, key)

        self.section.run(declare)
        return number

    def declare_queryable(self, key: str, callback: Callable[[Query], None], *, complete: bool) -> int:
        """Call `callback` with each query for this key; it ends each one, at any time."""
        key = canonical(key)
        number = self.next_number()
        entity = Queryable(callback, complete, encode_replier(self.zid, number))

        def declare() -> None:
            self.queryables.add(number, key, entity)
            self.expressions.use(key)
            self._forget_routes()
            self._tell_links(Kind.QUERYABLE, number, key, complete=complete)

        self.section.run(declare)
        return number

    def declare_token(self, key: str) -> int:
        """Show a key to all who watch."""
        check(key)
        number = self.next_number()

        def declare() -> None:
            self._tokens[number] = key
            self._tell_links(Kind.TOKEN, number, key)
            self.liveliness.appeared(key)

        self.section.run(declare)
        self.liveliness.tell()
        return number

    def watch_tokens(self, key: str, callback: Watcher, *, history: bool) -> int:
        """Tell of tokens that come and go, and with `history` of those there are, before this returns."""
        key = canonical(key)
        number = self.next_number()
        self.section.run(partial(self.liveliness.watch, number, key, callback, history=history))
        self.liveliness.tell()
        return number

    def tokens(self, key: str) -> list[str]:
        """Return the tokens there are now that meet `key`."""
        with self.section.lock:
            return self.liveliness.present(canonical(key))

    def undeclare(self, number: int) -> None:
        """Take back whatever was declared; an unknown number is no error."""
        self.section.run(partial(self._undeclare, number))
        self.liveliness.tell()

    def _undeclare(self, number: int) -> None:
        token = self._tokens.pop(number, None)
        if token is not None:
            self._take_back(Kind.TOKEN, number)
            self.liveliness.vanished(token)
        elif found := self.subscribers.pop(number):
            self._take_back(Kind.SUBSCRIBER, number)
            self.expressions.discard(found[0], self.links)
            self._forget_routes()
        elif taken := self.queryables.pop(number):
            self._take_back(Kind.QUERYABLE, number)
            self.expressions.discard(taken[0], self.links)
            self._forget_routes()
        else:
            self.liveliness.unwatch(number)

    def use_key(self, key: str) -> None:
        """Keep a number for a key until as many `Expressions.discard`."""
        self.section.run(partial(self.expressions.use, key))

    def _tell_links(self, kind: Kind, number: int, key: str, *, complete: bool = False) -> None:
        for link in self.links:
            if link.role is not Role.CLIENT or self._is_wanted(link, kind, key):
                link.declare(*self._declaration(link, kind, number, key, complete=complete))

    def _declaration(
        self,
        link: Link,
        kind: Kind,
        number: int,
        key: str,
        *,
        complete: bool = False,
        interest: int | None = None,
    ) -> list[bytes]:
        """Return what declares a thing on one link, the number of its key included."""
        out: list[bytes] = []
        # The key of a token is used once, so a number of its own would not pay.
        name = wire_key(key) if kind is Kind.TOKEN else self.expressions.name_own(link, key, out)
        if link.role is Role.CLIENT:
            link.told_of.add(number)
        out.append(declare(kind, number, name, complete=complete, interest=interest))
        return out

    def _is_wanted(self, link: Link, kind: Kind, key: str) -> bool:
        """Whether a client wants to know of what comes on a key."""
        return any(
            each.when & When.FUTURE and _ABOUT[kind] & each.about and self._is_about(link, each, key)
            for each in link.interests.values()
        )

    def _allows_interest(self, link: Link, wish: Interest) -> bool:
        if len(link.interests) >= bounds.MOST_INTERESTS:
            self.refuse('interest', f'session {show_id(link.zid)} has {bounds.MOST_INTERESTS} of them')
            return False
        return self._allows(link, len(wish.suffix))

    def _key_of(self, link: Link, wish: Interest) -> str | None:
        return link.key_of(wish.scope, wish.suffix, self.expressions.keys, wish.is_senders)

    def _is_about(self, link: Link, wish: Interest, key: str) -> bool:
        if not wish.has_key:
            return True
        wanted = self._key_of(link, wish)
        return wanted is not None and intersects(wanted, key)

    def _take_back(self, kind: Kind, number: int) -> None:
        for link in self.links:
            if link.role is not Role.CLIENT or number in link.told_of:
                link.told_of.discard(number)
                link.declare(take_back(kind, number))

    def _forget_routes(self) -> None:
        """The receivers have changed: look them up anew."""
        self.version += 1
        self._answerers.clear()
        for link in self.links:
            link.forget_receivers()

    # ---- links

    def is_linked(self, zid: bytes) -> bool:
        """Whether there is a link to a session."""
        return any(link.zid == zid for link in self.links)

    def link_is_up(self, link: Link) -> None:
        """Tell a new link what there is, and ask a router for what it has."""
        self.section.run(partial(self._link_is_up, link))
        self._when_changed()

    def _link_is_up(self, link: Link) -> None:
        self._settle_duplicate(link)
        self.links += (link,)
        out: list[bytes] = []
        if link.role is Role.ROUTER:
            self._changes += 1
            out.append(tell_of(Node(self.zid, self.identity.role, self.locators), self._changes))
        if link.role is Role.CLIENT:
            link.knows_all = True
        else:
            self._tell_all(link, out)
            if link.role is Role.PEER and self.identity.role is Role.PEER:
                out.append(final())
            else:
                out.append(interest(self.next_number(), When.PRESENT | When.FUTURE, About.ALL))
        link.declare(*out)
        self._forget_routes()

    def _settle_duplicate(self, link: Link) -> None:
        """Of two links to one session, both sides keep the one that the greater id has opened."""
        for other in self.links:
            if other.zid == link.zid:
                connector = self.zid if link.handshake.connects else link.zid
                before = self.zid if other.handshake.connects else other.zid
                if connector <= before:
                    raise ZenohProtocolError('there is a link to this session already', MAX_LINKS)
                self.links = tuple(each for each in self.links if each is not other)
                self._close_link(other, 'another link to this session replaces it', MAX_LINKS)

    def _tell_all(self, link: Link, out: list[bytes]) -> None:
        for number, key, _ in self.subscribers.all():
            out += self._declaration(link, Kind.SUBSCRIBER, number, key)
        for number, key, queryable in self.queryables.all():
            out += self._declaration(link, Kind.QUERYABLE, number, key, complete=queryable.complete)
        for number, key in self._tokens.items():
            out += self._declaration(link, Kind.TOKEN, number, key)

    def link_lost(self, link: Link) -> None:
        """A link has ended: what it had declared has gone, and it answers no query any more. Idempotent."""
        ended: list[PendingQuery] = []
        self.section.run(partial(self._link_lost, link, ended))
        self.liveliness.tell()
        for query in ended:
            self._end(query)
        self._when_changed()

    def _link_lost(self, link: Link, ended: list[PendingQuery]) -> None:
        if link.is_lost:
            return
        link.is_lost = True
        self.links = tuple(each for each in self.links if each is not link)
        for key in link.tokens.values():
            self.liveliness.vanished(key)
        link.tokens.clear()
        self._forget_routes()
        for request, query in list(self.pending.items()):
            if link in query.left:
                query.left.remove(link)
                if not query.left and self.pending.pop(request, None) is not None:
                    ended.append(query)

    # ---- what links tell

    def refuse(self, kind: str, reason: object) -> None:
        """Count something that came and is ignored."""
        self._when_refused(kind, reason)

    def _allows(self, link: Link, size: int) -> bool:
        """Whether a link may declare a key of so many bytes more."""
        cost = size + bounds.DECLARED_COST
        if link.declared + cost > bounds.DECLARED_LIMIT:
            self.refuse(
                'declaration', f'session {show_id(link.zid)} has declared {bounds.DECLARED_LIMIT >> 20} MiB'
            )
            return False
        link.declared += cost
        return True

    def declaration_came(self, link: Link, declaration: Declaration) -> None:
        """Take note of what the other side of a link declares or takes back."""
        self.section.run(partial(self._note_declaration, link, declaration))
        kind = declaration.kind
        if kind is Kind.TOKEN:
            self.liveliness.tell()
        elif kind is Kind.FINAL:
            self._when_changed()

    def _note_declaration(self, link: Link, declaration: Declaration) -> None:
        kind = declaration.kind
        if kind is Kind.FINAL:
            if not link.knows_all:
                link.knows_all = True
                self._forget_routes()
        elif declaration.taken_back:
            self._take_off(link, kind, declaration.number)
        else:
            key = link.key_of(
                declaration.scope, declaration.suffix, self.expressions.keys, declaration.is_senders
            )
            if key is not None:
                self._put_on(link, declaration, check(key))

    def _put_on(self, link: Link, declaration: Declaration, key: str) -> None:
        kind, number = declaration.kind, declaration.number
        if kind is Kind.EXPRESSION:
            if number and number not in link.expressions and self._allows(link, len(key)):
                link.expressions[number] = key
                link.expression_ids[key] = number
                link.forget_receivers()
            return
        if not number and declaration.interest is not None:
            return  # the answer to a question about the present alone
        if kind is Kind.TOKEN:
            if number not in link.tokens and self._allows(link, len(key)):
                link.tokens[number] = key
                self.liveliness.appeared(key)
            return
        self._take_off(link, kind, number)
        index = link.subscribers if kind is Kind.SUBSCRIBER else link.queryables
        if is_odd(key) and index.odd >= bounds.MOST_WILD:
            self.refuse('declaration', f'session {show_id(link.zid)} has {index.odd} with wildcards')
        elif self._allows(link, len(key)):
            if kind is Kind.SUBSCRIBER:
                link.subscribers.add(number, key, None)
            else:
                link.queryables.add(number, key, (declaration.complete, declaration.distance))

    def _take_off(self, link: Link, kind: Kind, number: int) -> None:
        if kind is Kind.EXPRESSION:
            key = link.expressions.pop(number, None)
            if key is not None:
                link.declared -= len(key) + bounds.DECLARED_COST
                if link.expression_ids.get(key) == number:
                    del link.expression_ids[key]
                self._forget_routes()
        elif kind is Kind.TOKEN:
            token = link.tokens.pop(number, None)
            if token is not None:
                link.declared -= len(token) + bounds.DECLARED_COST
                self.liveliness.vanished(token)
        else:
            found = (link.subscribers if kind is Kind.SUBSCRIBER else link.queryables).pop(number)
            if found is not None:
                link.declared -= len(found[0]) + bounds.DECLARED_COST
            self.version += 1

    def interest_came(self, link: Link, wish: Interest) -> None:
        """Answer what a client asks; peers and routers were told everything."""
        self._check_reads(link)
        self.section.run(partial(self._note_interest, link, wish))

    def _note_interest(self, link: Link, wish: Interest) -> None:
        before = link.interests.pop(wish.number, None)
        if before is not None:
            link.declared -= len(before.suffix) + bounds.DECLARED_COST
        if not wish.when:
            return
        out: list[bytes] = []
        is_known = not wish.has_key or self._key_of(link, wish) is not None
        if link.role is Role.CLIENT and is_known:
            if wish.when & When.FUTURE and self._allows_interest(link, wish):
                link.interests[wish.number] = wish
            if wish.when & When.PRESENT:
                self._tell_what_is_wanted(link, wish, out)
        if wish.when & When.PRESENT:
            out.append(final(wish.number))
        link.declare(*out)

    def _tell_what_is_wanted(self, link: Link, wish: Interest, out: list[bytes]) -> None:
        things: list[tuple[Kind, int, str, bool]] = []
        if wish.about & About.SUBSCRIBERS:
            things += [(Kind.SUBSCRIBER, number, key, False) for number, key, _ in self.subscribers.all()]
        if wish.about & About.QUERYABLES:
            things += [
                (Kind.QUERYABLE, number, key, each.complete) for number, key, each in self.queryables.all()
            ]
        if wish.about & About.TOKENS:
            things += [(Kind.TOKEN, number, key, False) for number, key in self._tokens.items()]
        for kind, number, key, complete in things:
            if self._is_about(link, wish, key):
                told = number if wish.when & When.FUTURE else 0
                out += self._declaration(link, kind, told, key, complete=complete, interest=wish.number)

    def nodes_came(self, link: Link, nodes: list[Node]) -> None:
        """Take note of nodes that a router tells of; the owner of the sockets connects to some."""
        if link.role is not Role.ROUTER or self.identity.role is not Role.PEER:
            return
        for node in nodes:
            if node.zid == self.zid:
                continue
            if node.zid not in self.nodes and len(self.nodes) >= bounds.MOST_NODES:
                self._forget_node()
            self.nodes[node.zid] = node
            if connects_to(self.zid, node) and not self.is_linked(node.zid):
                self._when_told(node)

    def _forget_node(self) -> None:
        """Make room for a node: forget the oldest to which there is no link."""
        linked = {link.zid for link in self.links}
        oldest = next((zid for zid in list(self.nodes) if zid not in linked), None)
        if oldest is not None:
            self.nodes.pop(oldest, None)
            self.refuse(
                'node of gossip', f'session {show_id(oldest)}; {bounds.MOST_NODES} newer ones are known'
            )

    # ---- what is put

    def receivers(self, link: Link, scope: int, suffix: bytes, is_senders: int) -> Receivers:
        """Return the receivers of what a link puts on one of its keys, and remember them."""
        receivers = _NOBODY

        def find() -> None:
            nonlocal receivers
            key = link.key_of(scope, suffix, self.expressions.keys, is_senders)
            if key is None:
                return
            found = tuple(each.callback for _, each in self.subscribers.meeting(key))
            receivers = Receivers(key, found)
            if len(suffix) > bounds.KEPT_KEY:
                return
            where = (scope, is_senders, suffix) if suffix else scope | is_senders << 16
            if len(link.push_receivers) >= bounds.ROUTES_LIMIT:
                link.forget_receivers()
            link.push_receivers[where] = receivers

        self.section.run(find)
        return receivers

    def is_forged(self, link: Link, source: bytes) -> bool:
        """Whether what came over a peer's link names a publisher of this session's, or one with its own link.

        Such a publisher's messages come over that link alone. Anything else cannot be told from what a peer
        passes on for clients that are linked to it, or a router for anybody.
        """
        try:
            zid = decode_source(source).zid
        except ZenohProtocolError:
            return False  # whoever looks at the source rejects it
        if zid == link.zid or not (zid == self.zid or self.is_linked(zid)):
            return False
        self.refuse(
            'forged message', f'session {show_id(link.zid)} sent it in the name of session {show_id(zid)}'
        )
        return True

    # ---- what is asked

    def ask(self, query: PendingQuery) -> int:
        """Take note of a query before it is sent; return its number."""
        request = self._next_request() & 0xFFFF_FFFF
        while request in self.pending:
            request = self._next_request() & 0xFFFF_FFFF
        self.pending[request] = query
        if query.deadline < self.next_timeout:
            self.next_timeout = query.deadline
            self._when_sooner()
        return request

    def cancel(self, request: int) -> None:
        """Cancel a query: neither of its functions is called any more. An ended one is no error."""
        query = self.pending.pop(request, None)
        if query is not None:
            query.left.clear()

    def last_word(self, who: object, request: int) -> None:
        """One that was asked has nothing more to say."""
        query = self.pending.get(request)
        if query is None:
            return
        try:
            query.left.remove(who)
        except ValueError:
            return
        if not query.left and self.pending.pop(request, None) is not None:
            self._end(query)

    def reply_key(self, link: Link, request: int, scope: int, suffix: bytes, is_senders: int) -> str | None:
        """Return the key that a reply is on, mostly that of its query; None where nobody waits for it."""
        query = self.pending.get(request)
        if query is None or link not in query.left:
            return None
        if not scope and suffix == query.encoded_key:
            return query.key
        return link.key_of(scope, suffix, self.expressions.keys, is_senders)

    def reply_came(self, link: Link, request: int, answer: Answer) -> None:
        """Hand a reply over."""
        query = self.pending.get(request)
        if query is not None and link in query.left:
            self._reply(query, answer)

    def query_came(
        self, link: Link, request: int, where: tuple[int, bytes, int], qos: int, query: QueryMessage
    ) -> None:
        """Hand a link's query to the queryables that it is for; where there is none, say so."""
        if link.queue.size > bounds.UNREAD_LIMIT:
            self._check_reads(link)
        scope, suffix, is_senders = where
        answerers = self._answerers.get((link, scope, suffix, is_senders))
        if answerers is None:
            answerers = self._find_answerers(link, scope, suffix, is_senders)
        key, queryables = answerers
        if not queryables:
            link.send(2 * (qos & 7) + 1, response_final(request, qos))
            return
        others = [None] * len(queryables)
        for queryable in queryables:
            asked = RemoteQuery(link, request, key, qos, query, queryable.replier, others)
            try:
                queryable.callback(asked)
            except Exception as error:
                self.callback_failed(error)

    def _check_reads(self, link: Link) -> None:
        """Raise ZenohProtocolError where a link asks on although it does not read the answers."""
        if link.queue.size > bounds.UNREAD_LIMIT:
            raise ZenohProtocolError(
                f'it asks, and leaves answers of {bounds.UNREAD_LIMIT >> 20} MiB unread', UNRESPONSIVE
            )

    def _find_answerers(self, link: Link, scope: int, suffix: bytes, is_senders: int) -> Answerers:
        answerers = Answerers('', ())

        def find() -> None:
            nonlocal answerers
            key = link.key_of(scope, suffix, self.expressions.keys, is_senders)
            if key is None:
                return
            answerers = Answerers(key, tuple(each for _, each in self.queryables.meeting(key)))
            if len(suffix) > bounds.KEPT_KEY:
                return
            if len(self._answerers) >= bounds.ROUTES_LIMIT:
                self._answerers.clear()
            self._answerers[link, scope, suffix, is_senders] = answerers

        self.section.run(find)
        return answerers

    # ---- users' functions

    def _reply(self, query: PendingQuery, answer: Answer) -> None:
        try:
            query.reply(answer)
        except Exception as error:
            self.callback_failed(error)

    def _end(self, query: PendingQuery) -> None:
        try:
            query.end()
        except Exception as error:
            self.callback_failed(error)

    def callback_failed(self, error: Exception) -> None:
        """Report what a user's function raised: it takes nobody else down."""
        report_failure(f'Zenoh session {self.id}', error)
