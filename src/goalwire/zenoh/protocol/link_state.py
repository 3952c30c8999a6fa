"""Gossip: routers announce peers to each other, and one of every two peers connects to the other.

A router sends OAM messages with the nodes that it knows. A new node is sent all others, and the others are
sent the new node. Each node has its id, role and the addresses ("locators") where it listens. Within one link
a node also has a short number, by which later messages may name it.

A peer always connects to routers. Of two peers the one with the greater id connects, compared byte by byte as
on the wire. So there is only one link between them.
"""

from __future__ import annotations

from goalwire.records import record
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.network import NODE_ID, OAM, QOS
from goalwire.zenoh.protocol.primitives import (
    FORM,
    MORE,
    Reader,
    ZenohProtocolError,
    encode_data,
    encode_text,
    encode_z,
)

_LINK_STATE = 1
_HAS_ID, _HAS_ROLE, _HAS_LOCATORS, _HAS_WEIGHTS = 1, 2, 4, 8
_NUMBER, _DATA = 1, 2
_ROLES = {1: Role.ROUTER, 2: Role.PEER, 4: Role.CLIENT}
_NUMBERS = {role: number for number, role in _ROLES.items()}


@record
class Node:
    """A node that a router has announced."""

    zid: bytes
    role: Role
    locators: tuple[str, ...] = ()
    change: int = 0
    """The version of this information about the node; the greatest version is valid."""


def tell_of(node: Node, change: int) -> bytes:
    """Return an OAM message about one node; `change` is the version of the information."""
    state = b''.join(
        (
            bytes((1, _HAS_ID | _HAS_ROLE | _HAS_LOCATORS, 0)),
            encode_z(change),
            encode_data(node.zid),
            bytes((_NUMBERS[node.role],)),
            encode_z(len(node.locators)),
            *map(encode_text, node.locators),
            b'\0',
        )
    )
    head = bytes((OAM | _DATA << 5 | MORE, _LINK_STATE, QOS, 0x08))
    return head + encode_data(state)


class LinkStates:
    """The nodes that one link has announced, and their short numbers."""

    def __init__(self) -> None:
        self._ids: dict[int, bytes] = {}

    def read(self, reader: Reader) -> list[Node]:
        """Read an OAM; return the nodes that it gives addresses of. Raises ZenohProtocolError."""
        header = reader.u8()
        about = reader.z(16)
        if header & MORE:
            reader.extensions({QOS, NODE_ID, 0x42})
        form = (header & FORM) >> 5
        if form == _NUMBER:
            reader.z()
        elif form == _DATA:
            body = reader.take_sized()
            if about == _LINK_STATE:
                return self._read_nodes(Reader(body))
        elif form:
            raise ZenohProtocolError(f'an OAM message has the form {form}, which does not exist')
        return []

    def _read_nodes(self, reader: Reader) -> list[Node]:
        found = (self._read_node(reader) for _ in range(reader.z(32)))
        return [node for node in found if node is not None]

    def _read_node(self, reader: Reader) -> Node | None:
        options = reader.z()
        number = reader.z()
        change = reader.z()
        # The id comes with the first message about a node. Later messages may have the short number only.
        if options & _HAS_ID:
            if number not in self._ids and len(self._ids) >= bounds.MOST_NODES:
                del self._ids[next(iter(self._ids))]
            self._ids[number] = reader.zid()
        role: Role | None = Role.ROUTER
        if options & _HAS_ROLE:
            role = _ROLES.get(reader.u8())
        locators = [reader.text() for _ in range(reader.z(32))] if options & _HAS_LOCATORS else []
        # The list of a node's own links matters to routers only. It is skipped.
        neighbours = reader.z(32)
        for _ in range(neighbours * (2 if options & _HAS_WEIGHTS else 1)):
            reader.z()
        zid = self._ids.get(number)
        if zid is None or role is None or not locators:
            return None
        return Node(zid, role, tuple(locators[: bounds.MOST_LOCATORS]), change)


def connects_to(own: bytes, node: Node) -> bool:
    """Return whether this side dials a node from gossip. If not, the node dials this side."""
    if node.zid == own or node.role is Role.CLIENT:
        return False
    return node.role is Role.ROUTER or own > node.zid
