"""The receivers of messages and queries that come over a link.

A message goes to the subscribers whose expression intersects its key, a query to the queryables whose
expression does. The receivers are looked up once for each key of a link and remembered until an entity or a
link comes or goes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.bodies import QueryMessage, Sample
from goalwire.zenoh.protocol.guard import Act, Witness
from goalwire.zenoh.protocol.incoming_queries import Query, RemoteQuery
from goalwire.zenoh.protocol.key_index import KeyIndex
from goalwire.zenoh.protocol.link import Link, Receivers
from goalwire.zenoh.protocol.links import Links
from goalwire.zenoh.protocol.network import response_final
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


def _count_refused(link: Link, sample: Sample) -> None:
    """Count a refused message: called instead of subscribers if the other side may not publish on a key."""
    if link.guard is not None:
        link.guard.count(Act.PUT, sample.key)


def _witness_of(link: Link, act: Act, key: str) -> Witness | None:
    """Return the witness of each `act` of the other side on `key`; None if there is none."""
    return None if link.guard is None else link.guard.witness(act, key)


def _tell_of_message(witness: Witness, sample: Sample) -> None:
    """Call the witness with a message; called before the subscribers of the message's key."""
    witness(sample.payload)


def _tell_witness(queryable: Queryable, witness: Witness) -> Queryable:
    """Return a stand-in for a queryable: it calls the witness with each query before the queryable."""
    answer = queryable.callback

    def tell(query: Query) -> None:
        witness(query.payload)
        answer(query)

    return queryable._replace(callback=tell)


def _refuser(link: Link, refusal: str, queryable: Queryable) -> Queryable:
    """Return a stand-in for a queryable that the other side may not query: it answers with an error."""

    def refuse(query: Query) -> None:
        if link.guard is not None:
            link.guard.count(Act.QUERY, query.key)
        query.reply_error(refusal.encode())
        query.end()

    return queryable._replace(callback=refuse)


class Routes:
    """One session's subscribers and queryables. Finds those that receive a link's message or query."""

    def __init__(
        self,
        section: CriticalSection,
        links: Links,
        own_zid: bytes,
        refuse: Callable[[str, object], object],
        report: Callable[[Exception], None],
    ) -> None:
        """`refuse` gets an ignored message's kind and the reason; `report` gets errors of callbacks."""
        self.version = 0
        """Counts the changes of entities and links. After each one, senders look up their receivers again."""
        self.subscribers: KeyIndex[Subscriber] = KeyIndex()
        self.queryables: KeyIndex[Queryable] = KeyIndex()
        self._section = section
        self._links = links
        self._own_zid = own_zid
        self._refuse = refuse
        self._report = report
        self._answerers: dict[tuple[Link, int, bytes, int], Answerers] = {}

    def forget(self) -> None:
        """Forget all remembered receivers: an entity or a link has come or gone, here or elsewhere."""
        self.version += 1
        self._answerers.clear()
        for link in self._links.up:
            link.forget_receivers()

    def note_change(self) -> None:
        """Have senders look up their receivers again: the other side of a link has changed its entities."""
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
            # The permission is looked up once for each key, not for each message.
            if found and link.refusal(Act.PUT, key):
                found = (partial(_count_refused, link),)
            elif found and (witness := _witness_of(link, Act.PUT, key)):
                found = (partial(_tell_of_message, witness), *found)
            receivers = Receivers(key, found, any(each.takes_views for each in subscribers))
            # Remembered within the section, so that no change of the subscribers can come between.
            link.remember_receivers(scope, suffix, is_senders, receivers)

        self._section.run(find)
        return receivers

    def is_forged(self, link: Link, source: bytes) -> bool:
        """Return whether a message falsely names a publisher of this session or of another link.

        Such a publisher's messages come over its own link only. Other sources cannot be checked: a peer may
        pass messages on for its clients, and a router for anybody.
        """
        try:
            zid = decode_source(source).zid
        except ZenohProtocolError:
            return False  # a malformed source is rejected later, when it is decoded
        if zid == link.zid or not (zid == self._own_zid or self._links.is_linked(zid)):
            return False
        self._refuse(
            'forged message', f'session {show_id(link.zid)} sent it in the name of session {show_id(zid)}'
        )
        return True

    def take_query(
        self, link: Link, request: int, where: tuple[int, bytes, int], qos: int, query: QueryMessage
    ) -> None:
        """Hand a link's query to the queryables that match it. If there are none, end the query at once."""
        outgoing = link.outgoing
        # hot path: the condition is written out here, which saves a call for each query.
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
        # The queryables share this list. The last of them to end sends the RESPONSE_FINAL.
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
            # Without a queryable the answer is not a refusal, so the asking side can look for another server.
            refusal = found and link.refusal(Act.QUERY, key)
            if refusal:
                found = (_refuser(link, refusal, found[0]),)
            elif found and (witness := _witness_of(link, Act.QUERY, key)):
                found = (_tell_witness(found[0], witness), *found[1:])
            answerers = Answerers(key, found)
            if len(suffix) > bounds.KEPT_KEY:
                return
            if len(self._answerers) >= bounds.ROUTES_LIMIT:
                self._answerers.clear()
            self._answerers[link, scope, suffix, is_senders] = answerers

        self._section.run(find)
        return answerers
