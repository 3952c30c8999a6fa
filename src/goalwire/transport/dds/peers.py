"""Who is behind an instance handle: the endpoint that a reader or writer is matched with."""

from __future__ import annotations

import ctypes
from ctypes import c_uint64
from typing import NamedTuple

from goalwire.transport.dds.abi import BuiltinEndpoint, Function, Library
from goalwire.transport.dds.qos import read_user_data
from goalwire.transport.dds.user_data import GUID_PREFIX_SIZE, EndpointData, decode_endpoint

_CACHE_LIMIT = 1000
"""Handles kept, those of endpoints that have gone among them: beyond it, all are asked for anew."""
_FAST_DDS = b'\x01\x0f'


class Peer(NamedTuple):
    """A matched endpoint."""

    gid: bytes
    service_id: str
    client_id: str
    takes_refusals: bool
    speaks_fast_dds: bool
    """True where the peer's implementation is Fast DDS, whose services have no header."""
    server: str
    """What the two ends of one server share."""


def _peer(gid: bytes, data: EndpointData) -> Peer:
    return Peer(
        gid,
        data.service_id,
        data.client_id,
        data.takes_refusals,
        gid[:2] == _FAST_DDS,
        data.service_id or gid[:GUID_PREFIX_SIZE].hex(),
    )


class Peers:
    """The matched endpoints asked for so far; a handle means the same one for ever."""

    def __init__(self, library: Library) -> None:
        self._library = library
        self.known: dict[int, Peer] = {}
        """By handle: looked at with each message, before anybody is asked."""

    def publication(self, reader: int, handle: int) -> Peer | None:
        """Return the writer that a reader is matched with; None where it has gone."""
        return self.known.get(handle) or self._ask(
            self._library.dds_get_matched_publication_data, reader, handle
        )

    def is_matched(self, reader: int, handle: int) -> bool:
        """Whether a reader is matched with that writer now."""
        address = self._library.dds_get_matched_publication_data(reader, handle)
        if address:
            self._library.dds_builtintopic_free_endpoint(address)
        return bool(address)

    def publications(self, reader: int) -> list[Peer]:
        """Return every writer that a reader is matched with."""
        handles = _handles(self._library.dds_get_matched_publications, reader)
        return [peer for handle in handles if (peer := self.publication(reader, handle)) is not None]

    def subscriptions(self, writer: int) -> list[Peer]:
        """Return every reader that a writer is matched with."""
        ask = self._library.dds_get_matched_subscription_data
        handles = _handles(self._library.dds_get_matched_subscriptions, writer)
        found = (self.known.get(handle) or self._ask(ask, writer, handle) for handle in handles)
        return [peer for peer in found if peer is not None]

    def _ask(self, function: Function, entity: int, handle: int) -> Peer | None:
        address = function(entity, handle)
        if not address:
            return None
        try:
            endpoint = ctypes.cast(address, ctypes.POINTER(BuiltinEndpoint)).contents
            peer = _peer(bytes(endpoint.key), decode_endpoint(read_user_data(self._library, endpoint.qos)))
        finally:
            self._library.dds_builtintopic_free_endpoint(address)
        if len(self.known) >= _CACHE_LIMIT:
            self.known.clear()
        self.known[handle] = peer
        return peer


def _handles(function: Function, entity: int) -> list[int]:
    room = 16
    while True:
        handles = (c_uint64 * room)()
        count = function(entity, handles, room)
        if count <= room:
            return list(handles[: max(count, 0)])
        room = 2 * count
