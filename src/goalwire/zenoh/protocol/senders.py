"""Publications and queriers, each for one key. They look up the receivers of the key, and remember them.

A query's target decides which queryables get it. All: every queryable whose expression intersects the key.
All complete: those that were declared complete and include the key. Best matching: the nearest complete
queryable, or all if none is complete.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from goalwire.zenoh.protocol.bodies import (
    LARGE,
    Consolidation,
    Payload,
    QueryMessage,
    Sample,
    del_body,
    new_sample,
    put_body,
    put_head,
    query_head,
    query_rest,
    shared_put_head,
)
from goalwire.zenoh.protocol.channels import channel_of
from goalwire.zenoh.protocol.guard import Act
from goalwire.zenoh.protocol.incoming_queries import LocalQuery
from goalwire.zenoh.protocol.key_expressions import canonical, includes
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.network import (
    BLOCK,
    DEFAULT_QOS,
    REQUEST,
    Target,
    WireKey,
    push_head,
    request_tail,
    wire_key,
)
from goalwire.zenoh.protocol.outgoing import QUEUE_LIMIT, Outgoing
from goalwire.zenoh.protocol.primitives import (
    MORE,
    SMALL_END,
    SMALL_Z,
    SourceInfo,
    encode_source,
    encode_z,
    show_id,
)
from goalwire.zenoh.protocol.queries import ANY_KEY, Answer, PendingQuery
from goalwire.zenoh.protocol.routes import Queryable
from goalwire.zenoh.protocol.session_protocol import SessionProtocol
from goalwire.zenoh.protocol.shared_memory import Loan, Pointer, encode_pointer

if TYPE_CHECKING:
    from goalwire.payload_parts import Parts

FLOOD = 32
"""More messages in a row than this are a flood (see `Stamps.burst`): the following messages may wait a
moment, to go out together. A callback that publishes twenty messages does not count as a flood."""
SMALL = 2048
"""Only messages of fewer bytes may wait. For a larger message the system call costs little in comparison."""
_NEVER = float('inf')
WHOLE = (bytes, memoryview)
"""The types of payloads in one piece; the others are Parts."""
Lent: TypeAlias = 'list[tuple[Outgoing, bytes, Pointer]]'
"""Links that get a message as a pointer, each with the head of the message and the pointer."""
Links: TypeAlias = 'tuple[tuple[Outgoing, bytes], ...]'
"""Links that get a message, each with the head of the message, which names the key as that link knows it."""
_HERE = object()
"""Stands for the session's own queryables among the links that a query waits for."""


def _take_back(lent: Lent) -> None:
    for link, _, pointer in lent:
        if link.memory is not None:
            link.memory.take_back(pointer)


class Publication:
    """Publishes messages on one key."""

    def __init__(
        self,
        session: SessionProtocol,
        key: str,
        *,
        priority: int = DEFAULT_QOS,
        reliable: bool = True,
        droppable: bool = True,
    ) -> None:
        self._session = session
        self._routes = session.routes
        self._key = canonical(key)
        self._channel = channel_of(priority, reliable=reliable)
        self._qos = priority if droppable else priority | BLOCK
        self._droppable = droppable
        self._version = -1
        self._links: Links = ()
        self._own: tuple[Callable[[Sample], None], ...] = ()
        self._shared_from: float = _NEVER
        """Payloads of this many bytes or more go through shared memory, on links that have some."""
        self._is_open = True
        self.number = session.next_number()
        session.use_key(self._key)

    def put(
        self,
        payload: Payload | Parts,
        attachment: bytes | None = None,
        stamp: bytes | None = None,
        source: SourceInfo | None = None,
    ) -> None:
        """Publish a message; `stamp` defaults to the session's next. Own subscribers are called at once."""
        session = self._session
        if self._version != self._routes.version:
            self._aim()
        if stamp is None:
            stamp = session.stamp()
        encoded_source = None if source is None else encode_source(source)
        links, size = self._links, len(payload)
        if size >= self._shared_from:
            links = self._share(payload, shared_put_head(attachment, stamp, encoded_source), links)
        if links:
            if size >= LARGE or not isinstance(payload, WHOLE):
                self._put_large(bytes(payload), put_head(size, attachment, stamp, encoded_source), links)
            else:
                body = put_body(payload, attachment, stamp, encoded_source)
                may_wait = size < SMALL and session.stamps.burst > FLOOD
                for link, head in links:
                    link.send(self._channel, head + body, self._droppable, may_wait)
        if self._own:
            whole = payload if isinstance(payload, WHOLE) else bytes(payload)
            sample = new_sample((self._key, whole, attachment, stamp, encoded_source))
            self._deliver(sample)

    def _share(self, payload: Payload | Parts, begin: bytes, links: Links) -> Links:
        """Send a payload through shared memory to the links that can take it; return the others.

        The payload is copied into a chunk once for all these links, and not copied if there are none.
        """
        pool = self._session.memory
        loan = None if pool is None else pool.borrow(len(payload))
        if loan is None:
            return links
        lent: Lent = []
        left: list[tuple[Outgoing, bytes]] = []
        try:
            for link, head in links:
                pointer = None if link.memory is None else link.memory.lend(loan)
                if pointer is None:
                    left.append((link, head))
                else:
                    lent.append((link, head, pointer))
            try:
                if lent and not loan.write(payload):
                    return links  # the session is closing, and has taken all loans back
            except BaseException:  # another thread has changed the message, or a signal handler has raised
                _take_back(lent)
                raise
            self._send_pointers(lent, begin)
        finally:
            loan.end()
        return tuple(left)

    def put_loan(self, loan: Loan, attach: Callable[[], bytes]) -> bool:
        """Publish a message that was written into a loan; `attach` makes its attachment.

        Return False, without publishing, if it cannot go through shared memory to all receivers.
        """
        if self._version != self._routes.version:
            self._aim()
        lent: Lent = []
        for link, head in self._links:
            pointer = None if link.memory is None else link.memory.lend(loan)
            if pointer is None:
                _take_back(lent)
                return False
            lent.append((link, head, pointer))
        attachment, stamp = attach(), self._session.stamp()
        self._send_pointers(lent, shared_put_head(attachment, stamp, None))
        if self._own:
            self._deliver(new_sample((self._key, bytes(loan.view), attachment, stamp, None)))
        return True

    def _send_pointers(self, lent: Lent, begin: bytes) -> None:
        for link, head, pointer in lent:
            message = b''.join((head, begin, encode_pointer(pointer)))
            if not link.send(self._channel, message, self._droppable) and link.memory is not None:
                link.memory.take_back(pointer)

    def _put_large(self, payload: bytes, begin: bytes, links: Links) -> None:
        """Send a PUT without copying its large payload: fresh memory of 1 MB costs over a millisecond."""
        for link, head in links:
            link.send_large(self._channel, (head + begin, payload), droppable=self._droppable)

    def put_where_free(
        self,
        payload: Payload | Parts,
        attachment: bytes | None,
        full: Container[object],
        *,
        waits: bool,
        stamp: bytes | None = None,
        source: SourceInfo | None = None,
    ) -> list[tuple[Outgoing, Callable[[], None]]]:
        """Publish one message on the links that have room. Return the other links, each with a function that
        sends the message there.

        The links in `full` count as links without room. With `waits`, the function waits for room before and
        after sending; otherwise it may drop the message.
        """
        session = self._session
        if self._version != self._routes.version:
            self._aim()
        if stamp is None:
            stamp = session.stamp()
        encoded_source = None if source is None else encode_source(source)
        size = len(payload)
        begin = put_head(size, attachment, stamp, encoded_source)
        # The key is named in full: its number may be undeclared before the message is sent.
        late = push_head(wire_key(self._key), self._qos | BLOCK if waits else self._qos) + begin
        left: list[tuple[Outgoing, Callable[[], None]]] = []
        links = self._links
        if size >= self._shared_from:
            free = tuple(each for each in links if each[0] not in full)
            shared = shared_put_head(attachment, stamp, encoded_source)
            not_shared = self._share(payload, shared, free)
            links = tuple(each for each in links if each[0] in full or each in not_shared)
        data = bytes(payload) if links else b''
        for link, head in links:
            if link not in full and (not waits or link.queue.size + size <= QUEUE_LIMIT):
                link.send_large(self._channel, (head + begin, data), droppable=self._droppable)
            else:
                left.append((link, partial(self._send_late, link, (late, data), droppable=not waits)))
        if self._own:
            whole = payload if isinstance(payload, WHOLE) else bytes(payload)
            sample = new_sample((self._key, whole, attachment, stamp, encoded_source))
            self._deliver(sample)
        return left

    def _send_late(self, link: Outgoing, message: tuple[bytes, bytes], *, droppable: bool) -> None:
        link.send_large(self._channel, message, droppable=droppable)
        if not droppable:
            link.wait_for_room()  # otherwise the small messages after a large one would be dropped

    def delete(self) -> None:
        """Tell the subscribers that the key has no value any more (DEL)."""
        session = self._session
        if self._version != self._routes.version:
            self._aim()
        stamp = session.stamp()
        body = del_body(None, stamp)
        for link, head in self._links:
            link.send(self._channel, head + body, self._droppable)
        self._deliver(Sample(self._key, None, None, stamp))

    def _deliver(self, sample: Sample) -> None:
        for callback in self._own:
            try:
                callback(sample)
            except Exception as error:
                self._session.report(error)

    def _aim(self) -> None:
        """Look up the receivers of the key."""
        if not self._session.section.run(partial(self._find, _name, is_final=True)):
            self._find(_full_name, is_final=False)

    def _find(self, name: Namer, *, is_final: bool) -> None:
        session, key = self._session, self._key
        version = session.routes.version
        self._own = tuple(
            each.callback for _, each in session.routes.subscribers.meeting(key) if each.takes_own
        )
        # A link that has not sent all its declarations may have a subscriber, so it gets the message, too. In
        # a look-up that interrupts a change (`is_final` is False), the tables are not trusted and all links
        # get it.
        self._links = tuple(
            (link.outgoing, push_head(name(session, link, key), self._qos))
            for link in session.links
            if (not is_final or not link.peer.knows_all or link.peer.subscribers.has_meeting(key))
            and not link.refusal(Act.RECEIVE, key)
        )
        pool = session.memory
        has_memory = pool is not None and any(link.memory is not None for link, _ in self._links)
        self._shared_from = pool.least if pool is not None and has_memory else _NEVER
        if is_final:  # set last: other threads only check the version before they send
            self._version = version

    def close(self) -> None:
        """Give up the number of the key. Idempotent."""
        self._session.section.run(self._close)

    def _close(self) -> None:
        if self._is_open:
            self._is_open = False
            self._session.expressions.discard(self._key, self._session.links)


Namer: TypeAlias = Callable[[SessionProtocol, Link, str], WireKey]


def _name(session: SessionProtocol, link: Link, key: str) -> WireKey:
    """Return the shortest name of a key on a link. If that is a new number, its declaration is sent first."""
    out: list[bytes] = []
    name = session.expressions.name(link, key, out)
    link.outgoing.declare(*out)
    return name


def _full_name(_session: SessionProtocol, _link: Link, key: str) -> WireKey:
    """Name a key in full: for calls that interrupt their own thread in a change of the session's tables."""
    return wire_key(key)


class _Asked(NamedTuple):
    """A link that gets a query, and the bytes of the query before and after the number of the request."""

    link: Link
    header: bytes
    rest: bytes


class Querier:
    """Sends queries on one key."""

    def __init__(
        self,
        session: SessionProtocol,
        key: str,
        *,
        target: int = Target.BEST_MATCHING,
        consolidation: int = Consolidation.NONE,
        qos: int = DEFAULT_QOS | BLOCK,
        asks_own: bool = True,
        parameters: str = '',
        session_asked: str = '',
    ) -> None:
        """If the session `session_asked` is linked, or is this session, only it gets the queries."""
        self._session = session
        self._routes = session.routes
        self._key = canonical(key)
        self._target = target
        self._consolidation = consolidation
        self._qos = qos
        self._asks_own = asks_own
        self._session_asked = session_asked
        self._parameters = parameters
        self._takes_any_key = ANY_KEY in parameters.split(';')
        self._encoded_key = self._key.encode()
        self._channel = channel_of(qos & 7)
        self._droppable = not qos & BLOCK
        self._version = -1
        self._links: tuple[_Asked, ...] = ()
        self._own: tuple[Queryable, ...] = ()
        self._tails: dict[tuple[float, bool, bool], bytes] = {}
        self._is_open = True
        session.use_key(self._key)

    def ask(
        self,
        payload: Payload | None,
        attachment: bytes | None,
        on_reply: Callable[[Answer], None],
        on_end: Callable[[], None],
        timeout_s: float,
    ) -> int:
        """Send a query and return the number that cancels it. Callbacks may run before `ask` returns."""
        session = self._session
        now = session.clock()
        if now > session.stale_after:
            session.relink()
        if self._version != self._routes.version:
            self._aim()
        links, own = self._links, self._own
        if len(links) == 1 and not own:
            left: list[object] = [links[0].link]
        else:
            left = [asked.link for asked in links]
            left += [_HERE] * len(own)
        query = PendingQuery(
            self._key,
            self._encoded_key,
            left,
            now + timeout_s,
            on_reply,
            on_end,
            takes_any_key=self._takes_any_key,
            consolidation=self._consolidation,
        )
        # Without a receiver the query ends at once, without an answer.
        if not left:
            query.end()
            return 0
        # The query is registered before it is sent: an answer may come on another thread at once.
        request = session.queries.add(query)
        if links:
            self._send(links, request, payload, attachment, timeout_s)
        for queryable in own:
            self._ask_own(
                queryable, request, query, QueryMessage(self._parameters, payload, attachment, None)
            )
        return request

    def _send(
        self,
        links: tuple[_Asked, ...],
        request: int,
        payload: Payload | None,
        attachment: bytes | None,
        timeout_s: float,
    ) -> None:
        form = (timeout_s, payload is not None, attachment is not None)
        tail = self._tails.get(form)
        if tail is None:
            tail = self._make_tail(*form)
        number = SMALL_Z[request] if request < SMALL_END else encode_z(request)
        body = tail + query_rest(payload, attachment)
        for link, header, rest in links:
            if not link.outgoing.send(self._channel, b''.join((header, number, rest, body)), self._droppable):
                # The request was not sent, so this link will never answer.
                self._session.queries.take_final(link, request)

    def _make_tail(self, timeout_s: float, has_payload: bool, has_attachment: bool) -> bytes:
        """Return the bytes between key and payload, equal in all requests with the same arguments."""
        if len(self._tails) > 256:
            self._tails.clear()
        milliseconds = min(int(timeout_s * 1000), 2**63)
        tail = request_tail(self._qos, self._target, milliseconds) + query_head(
            self._consolidation, self._parameters, has_payload=has_payload, has_attachment=has_attachment
        )
        self._tails[timeout_s, has_payload, has_attachment] = tail
        return tail

    def _ask_own(
        self, queryable: Queryable, request: int, query: PendingQuery, message: QueryMessage
    ) -> None:
        """Ask a queryable of this session, on this thread. Its end counts as the last answer of `_HERE`."""
        session = self._session
        asked = LocalQuery(message, query, lambda: session.queries.take_final(_HERE, request))
        try:
            queryable.callback(asked)
        except Exception as error:
            session.report(error)

    def _aim(self) -> None:
        """Look up the links and own queryables that get a query."""
        if not self._session.section.run(partial(self._find, _name, is_final=True)):
            self._find(_full_name, is_final=False)

    def _find(self, name: Namer, *, is_final: bool) -> None:
        session = self._session
        version = session.routes.version
        own = session.routes.queryables.meeting(self._key) if self._asks_own else []
        asked = self._find_links()
        links = [(link, link.peer.queryables.meeting(self._key)) for link in asked]
        # Links that have not sent all their declarations are asked in any case: they may have a queryable.
        if self._target == Target.BEST_MATCHING:
            nearest = self._nearest(links, own)
            if nearest is not None:
                links = [each for each in links if each[0] is nearest or not each[0].peer.knows_all]
                own = own if nearest is _HERE else []
        elif self._target == Target.ALL_COMPLETE:
            own = [(key, each) for key, each in own if self._is_complete(key, each.complete)]
            links = [
                (link, [(key, each) for key, each in queryables if self._is_complete(key, each[0])])
                for link, queryables in links
            ]
        self._own = tuple(queryable for _, queryable in own)
        self._links = tuple(
            self._ask(link, name)
            for link, queryables in links
            if queryables or (not link.peer.knows_all and not link.refusal(Act.REPLY, self._key))
        )
        if is_final:  # set last: other threads only check the version before they ask
            self._version = version

    def _find_links(self) -> tuple[Link, ...]:
        links, wanted = self._session.links, self._session_asked
        if wanted == self._session.id:
            return ()
        return tuple(link for link in links if wanted and show_id(link.zid) == wanted) or links

    def _is_complete(self, key: str, complete: bool) -> bool:
        """Return whether a queryable on `key` counts as complete for this querier's key."""
        return complete and includes(key, self._key)

    def _nearest(
        self,
        links: list[tuple[Link, list[tuple[str, tuple[bool, int]]]]],
        own: list[tuple[str, Queryable]],
    ) -> object:
        """Return the link with the nearest complete queryable, `_HERE` for an own one, or None."""
        if any(self._is_complete(key, each.complete) for key, each in own):
            return _HERE
        complete = [
            (distance, at)
            for at, (_, queryables) in enumerate(links)
            for key, (is_complete, distance) in queryables
            if self._is_complete(key, is_complete)
        ]
        return links[min(complete)[1]][0] if complete else None

    def _ask(self, link: Link, name_key: Namer) -> _Asked:
        name = name_key(self._session, link, self._key)
        return _Asked(link, bytes((REQUEST | MORE | name.flags,)), name.encoded)

    def close(self) -> None:
        """Give up the number of the key. Idempotent."""
        self._session.section.run(self._close)

    def _close(self) -> None:
        if self._is_open:
            self._is_open = False
            self._session.expressions.discard(self._key, self._session.links)
