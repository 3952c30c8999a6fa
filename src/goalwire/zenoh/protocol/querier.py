"""Queriers, each for one key. They look up the queryables of the key, and remember them.

A query's target decides which queryables get it. All: every queryable whose expression intersects the key.
All complete: those that were declared complete and include the key. Best matching: the nearest complete
queryable, or all if none is complete.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from goalwire.zenoh.protocol.bodies import (
    Consolidation,
    Payload,
    QueryMessage,
    query_head,
    query_rest,
)
from goalwire.zenoh.protocol.channels import channel_of
from goalwire.zenoh.protocol.expressions import Namer, name_in_full
from goalwire.zenoh.protocol.guard import Act
from goalwire.zenoh.protocol.incoming_queries import LocalQuery
from goalwire.zenoh.protocol.key_expressions import canonical, includes
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.network import (
    BLOCK,
    DEFAULT_QOS,
    REQUEST,
    Target,
    request_tail,
)
from goalwire.zenoh.protocol.primitives import (
    MORE,
    SMALL_END,
    SMALL_Z,
    encode_z,
    show_id,
)
from goalwire.zenoh.protocol.queries import ANY_KEY, Answer, PendingQuery
from goalwire.zenoh.protocol.routes import Queryable
from goalwire.zenoh.protocol.session_protocol import SessionProtocol

_HERE = object()
"""Stands for the session's own queryables among the links that a query waits for."""


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
        if not self._session.section.run(
            partial(self._find, self._session.expressions.declare, is_final=True)
        ):
            self._find(name_in_full, is_final=False)

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
        name = name_key(link, self._key)
        return _Asked(link, bytes((REQUEST | MORE | name.flags,)), name.encoded)

    def close(self) -> None:
        """Give up the number of the key. Idempotent."""
        self._session.section.run(self._close)

    def _close(self) -> None:
        if self._is_open:
            self._is_open = False
            self._session.expressions.discard(self._key, self._session.links)
