"""The nodes of a session and their endpoints, as ros_discovery_info announces them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from threading import Lock

from goalwire.rules.qos import DurabilityPolicy, HistoryPolicy, QoS
from goalwire.transport.contract import NodeName
from goalwire.transport.dds.discovery_state import (
    GID_SIZE,
    OLD_GID_SIZE,
    NodeInfo,
    ParticipantInfo,
    encode_info,
)

WRITTEN = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
READ = QoS(history=HistoryPolicy.KEEP_ALL, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""The QoS of writers and of readers of ros_discovery_info."""
_OLD = frozenset({'dashing', 'eloquent', 'foxy', 'galactic', 'humble'})


def gid_size() -> int:
    """Return how long Gids are in the ROS 2 that ROS_DISTRO names."""
    return OLD_GID_SIZE if os.environ.get('ROS_DISTRO', '').strip() in _OLD else GID_SIZE


class Announcement:
    """The nodes and endpoints of a session. The session publishes what `take` returns, after each change."""

    def __init__(self, guid: bytes) -> None:
        """`guid` is the GUID of the participant."""
        self._guid = guid
        self._gid_size = gid_size()
        self._lock = Lock()
        self._nodes: dict[int, tuple[NodeName, dict[bytes, None], dict[bytes, None]]] = {}
        # A session without nodes announces that, too, so that others do not wait for its nodes.
        self._changed = True

    def add_node(self, node_id: int, name: NodeName) -> None:
        """Add a node."""
        with self._lock:
            self._nodes[node_id] = name, {}, {}
            self._changed = True

    def remove_node(self, node_id: int) -> None:
        """Remove a node; an unknown one is ignored."""
        with self._lock:
            self._nodes.pop(node_id, None)
            self._changed = True

    def add(self, node_id: int, readers: Iterable[bytes], writers: Iterable[bytes]) -> None:
        """Add endpoints of a node."""
        with self._lock:
            _, all_readers, all_writers = self._nodes[node_id]
            all_readers.update(dict.fromkeys(readers))
            all_writers.update(dict.fromkeys(writers))
            self._changed = True

    def remove(self, node_id: int, gids: Iterable[bytes]) -> None:
        """Remove endpoints of a node; unknown ones are ignored."""
        with self._lock:
            if node_id not in self._nodes:
                return
            _, readers, writers = self._nodes[node_id]
            for gid in gids:
                readers.pop(gid, None)
                writers.pop(gid, None)
            self._changed = True

    def take(self) -> bytes | None:
        """Return the announcement to publish now; None if nothing has changed since the last one."""
        with self._lock:
            if not self._changed:
                return None
            self._changed = False
            nodes = tuple(
                NodeInfo(name.namespace, name.name, tuple(readers), tuple(writers))
                for name, readers, writers in self._nodes.values()
            )
        return encode_info(ParticipantInfo(self._guid, nodes), self._gid_size)

    def put_back(self) -> None:
        """Let `take` return the announcement again, since it could not be published."""
        with self._lock:
            self._changed = True
