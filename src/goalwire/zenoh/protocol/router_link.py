"""A router's link: hands each message with users' data to the router, which passes it on.

Only the head is changed: the number of a request, and the key, since numbers of keys are valid on one link
only. Priority, encoding, timestamp, attachment and payload are passed on as the same bytes.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from goalwire.zenoh.protocol.bodies import read_body, read_query
from goalwire.zenoh.protocol.handshake import Handshake
from goalwire.zenoh.protocol.link import Link, LinkOwner
from goalwire.zenoh.protocol.network import (
    DEFAULT_QOS,
    IS_NAMED,
    IS_SENDERS,
    QOS,
    TARGET,
    read_extensions,
    read_reply,
    read_request_id,
    read_wire_key,
)
from goalwire.zenoh.protocol.outgoing import Connection
from goalwire.zenoh.protocol.primitives import MORE, Reader, encode_data, encode_z


class Passing(NamedTuple):
    """A message on its way through a router."""

    header: int
    qos: int
    key: str
    rest: bytes
    """The part of the message after its key."""

    def encode(self, request: int | None = None) -> bytes:
        """Return the message with its key in full. REQUEST and RESPONSE have a number before the key."""
        number = b'' if request is None else encode_z(request)
        header = self.header & ~IS_SENDERS | IS_NAMED
        return b'%c%b\0%b%b' % (header, number, encode_data(self.key.encode()), self.rest)

    @property
    def channel(self) -> int:
        """The reliable channel of the message's priority."""
        return 2 * (self.qos & 7) + 1


class Relay(LinkOwner, Protocol):
    """A router, as far as its links need it."""

    def pass_put(self, link: Link, message: Passing) -> None:
        """Pass a PUSH of a link on to the subscribers of other links."""

    def pass_query(self, link: Link, request: int, target: int, message: Passing) -> None:
        """Pass a REQUEST of a link on to the queryables of other links."""

    def pass_reply(self, link: Link, request: int, message: Passing) -> None:
        """Pass a RESPONSE of a link on to the link that has asked."""


class RouterLink(Link):
    """One link of a router."""

    def __init__(self, relay: Relay, handshake: Handshake, connection: Connection, *, lease_ms: int) -> None:
        super().__init__(relay, handshake, connection, lease_ms=lease_ms)
        self._relay = relay

    def _take_push(self, data: bytes, at: int, end: int) -> int:
        """Read a PUSH only to find its key and end; its body is passed on unread."""
        header = data[at]
        scope, suffix, start = read_wire_key(data, at + 1, header)
        qos, body = read_extensions(data, start) if header & MORE else (DEFAULT_QOS, start)
        _, at = read_body(data, body, end, '')
        key = self.peer.key_of(scope, suffix, header & IS_SENDERS)
        if key is not None:
            self._relay.pass_put(self, Passing(header, qos, key, data[start:at]))
        return at

    def _take_request(self, data: bytes, at: int, end: int) -> int:
        """Read a REQUEST to find its key, target and end. For an unknown key the query ends at once."""
        header = data[at]
        request, at = read_request_id(data, at + 1)
        scope, suffix, start = read_wire_key(data, at, header)
        qos, target, body = DEFAULT_QOS, 0, start
        if header & MORE:
            qos, body = read_extensions(data, start)
            found = Reader(data, start, body).extensions({QOS, TARGET}).get(TARGET, 0)
            target = found if isinstance(found, int) else 0
        _, at = read_query(data, body, end)
        key = self.peer.key_of(scope, suffix, header & IS_SENDERS) or ''
        self._relay.pass_query(self, request, target, Passing(header, qos, key, data[start:at]))
        return at

    def _take_response(self, data: bytes, at: int, end: int) -> int:
        """Read a RESPONSE to find its key and end. The router finds the asking link by its number."""
        header = data[at]
        request, at = read_request_id(data, at + 1)
        scope, suffix, start = read_wire_key(data, at, header)
        qos, body = read_extensions(data, start) if header & MORE else (DEFAULT_QOS, start)
        _, at = read_reply(data, body, end, '')
        key = self.peer.key_of(scope, suffix, header & IS_SENDERS)
        if key is not None:
            self._relay.pass_reply(self, request, Passing(header, qos, key, data[start:at]))
        return at
