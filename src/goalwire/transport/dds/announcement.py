"""This participant's ros_discovery_info: which nodes it has, and whose its endpoints are."""

from __future__ import annotations

import os
from collections.abc import Iterable
from threading import Lock

from goalwire.rules.qos import DurabilityPolicy, HistoryPolicy, QoS
from goalwire.transport.contract import NodeName
from goalwire.transport.dds.names import DISCOVERY_TOPIC, DISCOVERY_TYPE
from goalwire.transport.dds.participant_info import (
    GID_SIZE,
    OLD_GID_SIZE,
    NodeInfo,
    ParticipantInfo,
    encode,
)
from goalwire.transport.dds.qos import endpoint_qos
from goalwire.transport.dds.wire import Participant, Reader, Writer

_WRITTEN = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_READ = QoS(history=HistoryPolicy.KEEP_ALL, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_OLD = frozenset({'dashing', 'eloquent', 'foxy', 'galactic', 'humble'})
_BLOCKING_NS = 1_000_000_000
"""How long a mute peer may hold an announcement up; it is then made with the next change."""


def gid_size() -> int:
    """Return how long Gids are in the ROS 2 that ROS_DISTRO names."""
    return OLD_GID_SIZE if os.environ.get('ROS_DISTRO', '').strip() in _OLD else GID_SIZE


class Announcement:
    """The nodes of a session and their endpoints, published by `publish` after each change."""

    def __init__(self, participant: Participant) -> None:
        self._guid = participant.guid
        self._gid_size = gid_size()
        self._lock = Lock()
        self._nodes: dict[int, tuple[NodeName, dict[bytes, None], dict[bytes, None]]] = {}
        self._changed = False
        with endpoint_qos(participant.library, _WRITTEN, b'', blocking_ns=_BLOCKING_NS) as qos:
            self._writer = Writer(participant, DISCOVERY_TOPIC, DISCOVERY_TYPE, qos)
        with endpoint_qos(participant.library, _READ, b'', ignore_local=True) as qos:
            self.reader = Reader(participant, DISCOVERY_TOPIC, DISCOVERY_TYPE, qos)

    def add_node(self, node_id: int, name: NodeName) -> None:
        """A node has come."""
        with self._lock:
            self._nodes[node_id] = name, {}, {}
            self._changed = True

    def remove_node(self, node_id: int) -> None:
        """A node has gone; an unknown one is no error."""
        with self._lock:
            self._nodes.pop(node_id, None)
            self._changed = True

    def add(self, node_id: int, readers: Iterable[bytes], writers: Iterable[bytes]) -> None:
        """Endpoints of a node have come."""
        with self._lock:
            _, all_readers, all_writers = self._nodes[node_id]
            all_readers.update(dict.fromkeys(readers))
            all_writers.update(dict.fromkeys(writers))
            self._changed = True

    def remove(self, node_id: int, gids: Iterable[bytes]) -> None:
        """Endpoints of a node have gone; unknown ones are no error."""
        with self._lock:
            if node_id not in self._nodes:
                return
            _, readers, writers = self._nodes[node_id]
            for gid in gids:
                readers.pop(gid, None)
                writers.pop(gid, None)
            self._changed = True

    def publish(self) -> None:
        """Tell the others, if anything has changed. One thread alone calls this."""
        with self._lock:
            if not self._changed:
                return
            self._changed = False
            nodes = tuple(
                NodeInfo(name.namespace, name.name, tuple(readers), tuple(writers))
                for name, readers, writers in self._nodes.values()
            )
        if self._writer.write(encode(ParticipantInfo(self._guid, nodes), self._gid_size)) < 0:
            with self._lock:
                self._changed = True
