"""rmw_dds_common/msg/ParticipantEntitiesInfo: which nodes a participant has, and whose its endpoints are.

Written by hand, not by the codec, for the wire has two forms: Gids of 16 bytes, and of 24 up to Humble.
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct

from goalwire.errors import RemoteError
from goalwire.transport.reports import check_names

GID_SIZE = 16
OLD_GID_SIZE = 24
"""Up to Humble: the same 16 bytes and 8 zeros."""
NAME_LIMIT = 256

_ENCAPSULATION = b'\x00\x01\x00\x00'
_U32 = Struct('<I')
_EMPTY_SIZE = len(_ENCAPSULATION) + GID_SIZE + _U32.size


@dataclass(frozen=True, slots=True)
class NodeInfo:
    """One node and the gids of its endpoints."""

    namespace: str
    name: str
    readers: tuple[bytes, ...] = ()
    writers: tuple[bytes, ...] = ()


@dataclass(frozen=True, slots=True)
class ParticipantInfo:
    """One participant's nodes."""

    gid: bytes
    nodes: tuple[NodeInfo, ...] = ()


def encode(info: ParticipantInfo, gid_size: int = GID_SIZE) -> bytes:
    """Return the message with Gids of 16 or 24 bytes."""
    parts = [_ENCAPSULATION, info.gid.ljust(gid_size, b'\0'), _U32.pack(len(info.nodes))]
    for node in info.nodes:
        for text in (node.namespace, node.name):
            raw = text.encode() + b'\0'
            raw = _U32.pack(len(raw)) + raw
            parts.append(raw.ljust(-(-len(raw) // 4) * 4, b'\0'))
        for gids in (node.readers, node.writers):
            parts.append(_U32.pack(len(gids)))
            parts += [gid.ljust(gid_size, b'\0') for gid in gids]
    return b''.join(parts)


def decode(payload: bytes) -> ParticipantInfo:
    """Read a message of either form; raises RemoteError for anything else."""
    if payload[:2] != _ENCAPSULATION[:2]:
        raise RemoteError(f'ros_discovery_info: encapsulation {payload[:4].hex()} is not little-endian CDR')
    return _Reader(payload, _gid_size(payload)).participant()


def _gid_size(payload: bytes) -> int:
    """Tell the two forms apart: after the participant's gid come 8 zeros, or a count and a length."""
    tail = payload[len(_ENCAPSULATION) + GID_SIZE :][: OLD_GID_SIZE - GID_SIZE]
    has_room = len(payload) > _EMPTY_SIZE
    return OLD_GID_SIZE if has_room and tail == bytes(OLD_GID_SIZE - GID_SIZE) else GID_SIZE


class _Reader:
    """Reads one message from front to back."""

    def __init__(self, payload: bytes, gid_size: int) -> None:
        self._payload = payload
        self._position = len(_ENCAPSULATION)
        self._gid_size = gid_size

    def participant(self) -> ParticipantInfo:
        try:
            gid = self._gid()
            return ParticipantInfo(gid, tuple(self._node() for _ in range(self._count(4))))
        except UnicodeDecodeError as error:
            raise RemoteError(f'ros_discovery_info: at byte {self._position}: {error}') from None

    def _node(self) -> NodeInfo:
        namespace, name = self._text(), self._text()
        return NodeInfo(namespace, name, self._gids(), self._gids())

    def _take(self, size: int) -> bytes:
        taken = self._payload[self._position : self._position + size]
        if len(taken) < size:
            raise RemoteError(
                f'ros_discovery_info: at byte {self._position}: {size} bytes expected, {len(taken)} left'
            )
        self._position += size
        return taken

    def _count(self, least_size: int) -> int:
        """Read a count of items of at least that size; raises RemoteError where they do not fit."""
        self._position += -self._position % 4
        (count,) = _U32.unpack(self._take(4))
        if count * least_size > len(self._payload):
            raise RemoteError(f'ros_discovery_info: at byte {self._position}: {count} items do not fit')
        return int(count)

    def _text(self) -> str:
        raw = self._take(self._count(1)).removesuffix(b'\0')
        if len(raw) > NAME_LIMIT:
            raise RemoteError(f'ros_discovery_info: a name of {len(raw)} bytes, {NAME_LIMIT} are allowed')
        name = raw.decode()
        check_names('ros_discovery_info', name)
        return name

    def _gids(self) -> tuple[bytes, ...]:
        return tuple(self._gid() for _ in range(self._count(self._gid_size)))

    def _gid(self) -> bytes:
        return self._take(self._gid_size)[:GID_SIZE]
