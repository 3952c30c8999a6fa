"""Introduces the peers of a router to each other: each peer is sent the addresses of the others."""

from __future__ import annotations

from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.link_state import Node, tell_of
from goalwire.zenoh.protocol.links import Links


class Introductions:
    """The peers of one router. Callers hold the router's section."""

    def __init__(self, links: Links) -> None:
        self._links = links
        self._nodes: dict[bytes, Node] = {}

    def tell_all(self) -> list[bytes]:
        """Return the messages that tell a new peer of the others."""
        return [tell_of(node, node.change) for node in self._nodes.values()]

    def take(self, link: Link, nodes: list[Node]) -> None:
        """Take note of a peer's addresses, and tell the other peers. A peer may announce only itself."""
        for node in nodes:
            if node.zid != link.zid or link.role is not Role.PEER:
                continue
            self._nodes[node.zid] = node
            for other in self._links.up:
                if other is not link and other.role is not Role.CLIENT:
                    other.outgoing.declare(tell_of(node, node.change))

    def forget(self, zid: bytes) -> None:
        """Forget a peer whose link has ended. An unknown peer is not an error."""
        self._nodes.pop(zid, None)
