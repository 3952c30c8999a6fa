"""The receivers of what comes over a link: callbacks for each message, queryables for each query.

A message goes to the subscribers whose expression intersects its key, and a query to such queryables. That is
looked up once for each key of a link and remembered, until somebody declares or takes back anything.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.guard import Act
from goalwire.zenoh.protocol.incoming_queries import Query, RemoteQuery
from goalwire.zenoh.protocol.key_index import KeyIndex
from goalwire.zenoh.protocol.link import Link, Receivers
from goalwire.zenoh.protocol.links import Links
from goalwire.zenoh.protocol.network import QueryMessage, Sample, response_final
from goalwire.zenoh.protocol.primitives import ZenohProtocolError, decode_source, show_id


class Subscriber(NamedTuple):
    """A subscriber of this session's."""

    callback: Callable[[Sample], None]
    takes_own: bool
    takes_views: bool = False


class Queryable(NamedTuple):
    """A queryable of this session's."""

    callback: Callable[[Query], None]
    complete: bool
    replier: bytes


class Answerers(NamedTuple):
    """The queryables that answer a link's queries on one key."""

    key: str
    queryables: tuple[Queryable, ...]


_NOBODY = Receivers('', ())


def _count_refused(link: Link, _sample: Sample) -> None:
    """Stand in for the subscribers if the other side of a link may not put on a key."""
    if link.guard is not None:
        link.guard.count(Act.PUT)


def _refuser(link: Link, refusal: str, queryable: Queryable) -> Queryable:
    """Return a stand-in for a queryable that the other side of a link may not ask."""

    def refuse(query: Query) -> None:
        if link.guard is not None:
            link.guard.count(Act.QUERY)
        query.reply_error(refusal.encode())
        query.end()

    return queryable._replace(callback=refuse)


class Routes:
    """One session's subscribers and queryables, and which of them get what each link sends."""

    def __init__(
        self,
        section: CriticalSection,
        links: Links,
        own_zid: bytes,
        refuse: Callable[[str, object], object],
        report: Callable[[Exception], None],
    ) -> None:
        """`refuse` gets the kind of an ignored message, and the reason; `report` gets what a user's function
        raised.
        """
        self.version = 0
        """Counts the changes of who gets what: senders look up their receivers again after each."""
        self.subscribers: KeyIndex[Subscriber] = KeyIndex()
        self.queryables: KeyIndex[Queryable] = KeyIndex()
        self._section = section
        self._links = links
        self._own_zid = own_zid
        self._refuse = refuse
        self._report = report
        self._answerers: dict[tuple[Link, int, bytes, int], Answerers] = {}

    def forget(self) -> None:
        """Look everything up anew: an entity or a link has come or gone, here or elsewhere."""
        self.version += 1
        self._answerers.clear()
        for link in self._links.up:
            link.forget_receivers()

    def note_change(self) -> None:
        """Have senders look up their receivers again: the other side of a link has declared something."""
        self.version += 1

    def receivers(self, link: Link, scope: int, suffix: bytes, is_senders: int) -> Receivers:
        """Return the receivers of a link's messages on one key, and have the link remember them."""
        receivers = _NOBODY

        def find() -> None:
            nonlocal receivers
            key = link.peer.key_of(scope, suffix, is_senders)
            if key is None:
                return
            subscribers = [each for _, each in self.subscribers.meeting(key)]
            found = tuple(each.callback for each in subscribers)
            if found and link.refusal(Act.PUT, key):
                found = (partial(_count_refused, link),)
            receivers = Receivers(key, found, any(each.takes_views for each in subscribers))
            link.remember_receivers(scope, suffix, is_senders, receivers)

        self._section.run(find)
        return receivers

    def is_forged(self, link: Link, source: bytes) -> bool:
        """Whether what came over a peer's link names a publisher of this session's, or one with its own link.

        Such a publisher's messages come over that link only. Anything else cannot be told from what a peer
        passes on for clients that are linked to it, or a router for anybody.
        """
        try:
            zid = decode_source(source).zid
        except ZenohProtocolError:
            return False  # the layer that reads the source rejects it
        if zid == link.zid or not (zid == self._own_zid or self._links.is_linked(zid)):
            return False
        self._refuse(
            'forged message', f'session {show_id(link.zid)} sent it in the name of session {show_id(zid)}'
        )
        return True

    def take_query(
        self, link: Link, request: int, where: tuple[int, bytes, int], qos: int, query: QueryMessage
    ) -> None:
        """Hand a link's query to the queryables that it is for; if there is none, say so."""
        outgoing = link.outgoing
        # hot path: the check is written out here, which saves each query a call.
        if outgoing.queue.size > bounds.UNREAD_LIMIT:
            link.check_reads()
        scope, suffix, is_senders = where
        answerers = self._answerers.get((link, scope, suffix, is_senders))
        if answerers is None:
            answerers = self._find_answerers(link, scope, suffix, is_senders)
        key, queryables = answerers
        if not queryables:
            outgoing.send(2 * (qos & 7) + 1, response_final(request, qos))
            return
        others = [None] * len(queryables)
        for queryable in queryables:
            asked = RemoteQuery(outgoing, request, key, qos, query, queryable.replier, others)
            try:
                queryable.callback(asked)
            except Exception as error:
                self._report(error)

    def _find_answerers(self, link: Link, scope: int, suffix: bytes, is_senders: int) -> Answerers:
        answerers = Answerers('', ())

        def find() -> None:
            nonlocal answerers
            key = link.peer.key_of(scope, suffix, is_senders)
            if key is None:
                return
            found = tuple(each for _, each in self.queryables.meeting(key))
            # Nobody is refused what is not here: the one who asks then goes on to look for a server.
            refusal = found and link.refusal(Act.QUERY, key)
            answerers = Answerers(key, (_refuser(link, refusal, found[0]),) if refusal else found)
            if len(suffix) > bounds.KEPT_KEY:
                return
            if len(self._answerers) >= bounds.ROUTES_LIMIT:
                self._answerers.clear()
            self._answerers[link, scope, suffix, is_senders] = answerers

        self._section.run(find)
        return answerers
