"""The entities of a router's links. The router announces them to its other links.

A router tells a link only of entities that the link has asked for. It does not tell two peers of each other's
entities: the peers have a link of their own, on which each declares its entities.
"""

from __future__ import annotations

from itertools import count
from typing import NamedTuple

from goalwire.zenoh.protocol.declarations import (
    Declaration,
    Interest,
    Kind,
    When,
    declare,
    final,
    take_back,
)
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.links import Links
from goalwire.zenoh.protocol.network import wire_key


class _Relayed(NamedTuple):
    """An entity of one link, with the number under which the other links know it."""

    number: int
    key: str
    complete: bool


class RelayedEntities:
    """The entities of all links of one router. Callers hold the router's section."""

    def __init__(self, links: Links, *, passes_on: bool) -> None:
        """With `passes_on` False, the router tells no link of any entity."""
        self._links = links
        self._passes_on = passes_on
        self._of: dict[Link, dict[tuple[Kind, int], _Relayed]] = {}
        self._next_number = count(1).__next__

    def others(self, link: Link) -> list[Link]:
        """Return the links that a link exchanges messages with: a client with all, a peer with clients."""
        if not self._passes_on:
            return []
        is_client = link.role is Role.CLIENT
        return [
            each for each in self._links.up if each is not link and (is_client or each.role is Role.CLIENT)
        ]

    def add(self, link: Link, declaration: Declaration, key: str) -> None:
        """Tell the other links of an entity that a link has declared."""
        kind = declaration.kind
        # An entity that is declared under a number in use replaces the earlier entity.
        self.remove(link, kind, declaration.number)
        entity = _Relayed(self._next_number() & 0xFFFF_FFFF, key, declaration.complete)
        self._of.setdefault(link, {})[kind, declaration.number] = entity
        for other in self.others(link):
            if other.peer.wants(kind, key):
                other.peer.told_of.add(entity.number)
                other.outgoing.declare(_declaration(kind, entity))

    def remove(self, link: Link, kind: Kind, number: int) -> None:
        """Tell the other links that a link has undeclared an entity. An unknown number changes nothing."""
        entity = self._of.get(link, {}).pop((kind, number), None)
        if entity is not None:
            self._take_back(kind, entity)

    def remove_link(self, link: Link) -> None:
        """Tell the other links that all entities of a link have gone."""
        for (kind, _), entity in self._of.pop(link, {}).items():
            self._take_back(kind, entity)

    def _take_back(self, kind: Kind, entity: _Relayed) -> None:
        for other in self._links.up:
            if entity.number in other.peer.told_of:
                other.peer.told_of.discard(entity.number)
                other.outgoing.declare(take_back(kind, entity.number))

    def take_interest(self, link: Link, wish: Interest) -> None:
        """Answer an interest of a link, and remember it if it also asks for future entities."""
        peer = link.peer
        # An INTEREST replaces an earlier one with its number; with FINAL it only withdraws the earlier one.
        peer.remove_interest(wish.number)
        if not wish.when:
            return
        out: list[bytes] = []
        if not wish.has_key or peer.find_key(wish) is not None:
            if wish.when & When.FUTURE:
                peer.add_interest(wish)
            if wish.when & When.PRESENT:
                out += self._answer(link, wish)
        if wish.when & When.PRESENT:
            # The final is sent even if there is nothing to declare: the other side waits for it.
            out.append(final(wish.number))
        link.outgoing.declare(*out)

    def _answer(self, link: Link, wish: Interest) -> list[bytes]:
        """Return the declarations that answer a link's interest."""
        out: list[bytes] = []
        for other in self.others(link):
            for (kind, _), entity in self._of.get(other, {}).items():
                if not link.peer.is_met(wish, kind, entity.key):
                    continue
                if wish.when & When.FUTURE:
                    link.peer.told_of.add(entity.number)
                else:  # the link never learns of the entity's end, so the entity gets no number
                    entity = entity._replace(number=0)
                out.append(_declaration(kind, entity, wish.number))
        return out


def _declaration(kind: Kind, entity: _Relayed, interest: int | None = None) -> bytes:
    return declare(kind, entity.number, wire_key(entity.key), complete=entity.complete, interest=interest)
