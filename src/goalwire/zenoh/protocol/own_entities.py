"""The entities that this session has declared. Announces them to the links.

Peers and routers are told of all entities at once. A client is told only of those that it has asked for.
"""

from __future__ import annotations

from goalwire.zenoh.protocol.declarations import (
    About,
    Interest,
    Kind,
    When,
    declare,
    final,
    take_back,
)
from goalwire.zenoh.protocol.expressions import Expressions
from goalwire.zenoh.protocol.guard import Act
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.links import Links
from goalwire.zenoh.protocol.liveliness_tokens import Liveliness
from goalwire.zenoh.protocol.network import wire_key
from goalwire.zenoh.protocol.routes import Queryable, Routes, Subscriber

_LEARNS = {
    Kind.SUBSCRIBER: Act.LEARN_SUBSCRIBER,
    Kind.QUERYABLE: Act.LEARN_QUERYABLE,
    Kind.TOKEN: Act.LEARN_TOKEN,
}


class OwnEntities:
    """A session's subscribers, queryables and tokens. Callers hold the session's section."""

    def __init__(
        self, links: Links, expressions: Expressions, routes: Routes, liveliness: Liveliness
    ) -> None:
        self._links = links
        self._expressions = expressions
        self._routes = routes
        self._liveliness = liveliness
        self._tokens: dict[int, str] = {}

    def add_subscriber(self, number: int, key: str, subscriber: Subscriber) -> None:
        """Declare a subscriber."""
        self._routes.subscribers.add(number, key, subscriber)
        self._expressions.use(key)
        self._routes.forget()
        self._tell_links(Kind.SUBSCRIBER, number, key)

    def add_queryable(self, number: int, key: str, queryable: Queryable) -> None:
        """Declare a queryable."""
        self._routes.queryables.add(number, key, queryable)
        self._expressions.use(key)
        self._routes.forget()
        self._tell_links(Kind.QUERYABLE, number, key, complete=queryable.complete)

    def add_token(self, number: int, key: str) -> None:
        """Declare a token."""
        self._tokens[number] = key
        self._tell_links(Kind.TOKEN, number, key)
        self._liveliness.appeared(key)

    def remove(self, number: int) -> bool:
        """Undeclare the entity with a number. Return False if there is none."""
        token = self._tokens.pop(number, None)
        if token is not None:
            self._take_back(Kind.TOKEN, number)
            self._liveliness.vanished(token)
            return True
        kind = Kind.SUBSCRIBER
        found: tuple[str, object] | None = self._routes.subscribers.pop(number)
        if found is None:
            kind = Kind.QUERYABLE
            found = self._routes.queryables.pop(number)
        if found is None:
            return False
        self._take_back(kind, number)
        self._expressions.discard(found[0], self._links.up)
        self._routes.forget()
        return True

    def _tell_links(self, kind: Kind, number: int, key: str, *, complete: bool = False) -> None:
        """Declare a new entity on all links whose other side wants it and may learn of it."""
        for link in self._links.up:
            if (link.role is not Role.CLIENT or link.peer.wants(kind, key)) and self._may_learn(
                link, kind, key
            ):
                link.outgoing.declare(*self._declaration(link, kind, number, key, complete=complete))

    @staticmethod
    def _may_learn(link: Link, kind: Kind, key: str) -> bool:
        """Return whether the other side of a link may learn of an entity."""
        return not link.refusal(_LEARNS[kind], key)

    def _take_back(self, kind: Kind, number: int) -> None:
        for link in self._links.up:
            # A client or a guarded link learns of the end only of entities that it knows (`told_of`).
            told_of = link.peer.told_of
            is_told_all = link.role is not Role.CLIENT and link.guard is None
            if is_told_all or number in told_of:
                told_of.discard(number)
                link.outgoing.declare(take_back(kind, number))

    def tell_all(self, link: Link) -> list[bytes]:
        """Return the messages that declare all entities to a new link."""
        out: list[bytes] = []
        for kind, number, key, complete in self._all(About.ALL):
            if not self._may_learn(link, kind, key):
                continue
            out += self._declaration(link, kind, number, key, complete=complete)
        return out

    def tell_wanted(self, link: Link, wish: Interest) -> list[bytes]:
        """Return the messages that answer an interest: the entities, and the end of the list."""
        out: list[bytes] = []
        for kind, number, key, complete in self._all(wish.about):
            if link.peer.is_about(wish, key) and self._may_learn(link, kind, key):
                # A client that asks only for present entities does not learn of their end: the number is 0.
                told = number if wish.when & When.FUTURE else 0
                out += self._declaration(link, kind, told, key, complete=complete, interest=wish.number)
        return out

    def _all(self, about: About) -> list[tuple[Kind, int, str, bool]]:
        """Return kind, number, key and completeness of all entities, subscribers first."""
        things: list[tuple[Kind, int, str, bool]] = []
        if about & About.SUBSCRIBERS:
            things += [(Kind.SUBSCRIBER, at, key, False) for at, key, _ in self._routes.subscribers.all()]
        if about & About.QUERYABLES:
            things += [
                (Kind.QUERYABLE, at, key, each.complete) for at, key, each in self._routes.queryables.all()
            ]
        if about & About.TOKENS:
            things += [(Kind.TOKEN, at, key, False) for at, key in self._tokens.items()]
        return things

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
        """Return the messages that declare an entity on one link, and the number of its key if it is new."""
        out: list[bytes] = []
        # The key of a token is used once, so declaring a number for it would cost more than it saves.
        name = wire_key(key) if kind is Kind.TOKEN else self._expressions.name_own(link, key, out)
        if link.role is Role.CLIENT or link.guard is not None:
            link.peer.told_of.add(number)
        out.append(declare(kind, number, name, complete=complete, interest=interest))
        return out

    def take_interest(self, link: Link, wish: Interest) -> None:
        """Answer a client's interest. Peers and routers were told of all entities before."""
        peer = link.peer
        # An INTEREST replaces an earlier one with its number; with FINAL it only withdraws the earlier one.
        peer.remove_interest(wish.number)
        if not wish.when:
            return
        out: list[bytes] = []
        is_known = not wish.has_key or peer.find_key(wish) is not None
        if link.role is Role.CLIENT and is_known:
            if wish.when & When.FUTURE:
                peer.add_interest(wish)
            if wish.when & When.PRESENT:
                out += self.tell_wanted(link, wish)
        if wish.when & When.PRESENT:
            # The final is sent even if there is nothing to declare: the other side waits for it.
            out.append(final(wish.number))
        link.outgoing.declare(*out)
