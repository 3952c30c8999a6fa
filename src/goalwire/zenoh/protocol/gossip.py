"""The nodes that routers announce, and how this session is announced to routers."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.handshake import Identity
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.link_state import Node, connects_to, tell_of
from goalwire.zenoh.protocol.links import Links
from goalwire.zenoh.protocol.primitives import show_id


class Gossip:
    """The nodes that one session knows of."""

    def __init__(
        self,
        identity: Identity,
        links: Links,
        meet: Callable[[Node], None],
        refuse: Callable[[str, object], object],
    ) -> None:
        """`meet` gets the nodes to connect to; `refuse` gets an ignored message's kind and the reason."""
        self.nodes: dict[bytes, Node] = {}
        self.locators: tuple[str, ...] = ()
        """The addresses where this session listens; set before the first link."""
        self._identity = identity
        self._links = links
        self._meet = meet
        self._refuse = refuse
        self._changes = 0

    def introduce(self) -> bytes:
        """Return a message that announces this session to a router."""
        self._changes += 1
        return tell_of(Node(self._identity.zid, self._identity.role, self.locators), self._changes)

    def take(self, link: Link, nodes: list[Node]) -> None:
        """Remember the nodes that a router announces, and connect to those that this side has to dial."""
        # Only routers announce other nodes, and only peers connect to them.
        if link.role is not Role.ROUTER or self._identity.role is not Role.PEER:
            return
        zid = self._identity.zid
        for node in nodes:
            # A router also announces this session itself.
            if node.zid == zid:
                continue
            if node.zid not in self.nodes and len(self.nodes) >= bounds.MOST_NODES:
                self._forget_oldest()
            self.nodes[node.zid] = node
            if connects_to(zid, node) and not self._links.is_linked(node.zid):
                self._meet(node)

    def forget(self, zid: bytes) -> None:
        """Forget a node; an unknown node is not an error."""
        self.nodes.pop(zid, None)

    def _forget_oldest(self) -> None:
        """Make room: forget the oldest node without a link."""
        linked = {link.zid for link in self._links.up}
        oldest = next((zid for zid in list(self.nodes) if zid not in linked), None)
        if oldest is not None:
            self.forget(oldest)
            self._refuse(
                'node of gossip', f'session {show_id(oldest)}; {bounds.MOST_NODES} newer ones are known'
            )
