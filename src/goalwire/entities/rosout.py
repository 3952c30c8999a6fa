"""/rosout: publishes what nodes log (rcl's logging_rosout).

A record goes out through the node whose logger has its name, or an ancestor of its name. Nodes with the same
logger name share one publisher, and when its node goes the next of them takes it over. The publisher never
waits for room on the wire: log lines come from any thread, also from those of the transport.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from struct import Struct
from threading import Lock
from typing import TYPE_CHECKING, Protocol
from weakref import ref

from goalwire.entities.endpoint import InGraph, describe_endpoint
from goalwire.entities.standard_types import standard_message
from goalwire.errors import ClosedError, ForkedError
from goalwire.logging import LogRecord, SinkHandle, add_sink, get_logger
from goalwire.rules.qos import ROSOUT, QoS
from goalwire.rules.time import LATEST_STAMP, S_TO_NS
from goalwire.transport.contract import EndpointKind, PublisherPort

if TYPE_CHECKING:
    from goalwire.entities.dropped_nodes import Remains
    from goalwire.transport.contract import NodePort

TOPIC = '/rosout'
LOG = 'rcl_interfaces/msg/Log'

_HEAD = Struct('<4siIB')
"""The header of little-endian CDR, then stamp and level."""
_NUMBER = Struct('<I')


class LoggingNode(InGraph, Protocol):
    """A node, as far as publishing its log needs it."""

    @property
    def logger_name(self) -> str:
        """The name of the node's logger: 'a.b.name' for the node /a/b/name."""

    @property
    def port(self) -> NodePort:
        """The node on the wire, through which endpoints are declared."""

    def resolve(self, name: str) -> str:
        """Return the fully-qualified name of a topic."""

    def own(self, entity: _Outlet) -> None:
        """Register `entity`, which is then destroyed together with the node."""

    def disown(self, entity: _Outlet) -> None:
        """Forget an entity that destroys itself."""

    @property
    def remains(self) -> Remains:
        """Ends the publisher if the program drops the node."""


class Rosout:
    """Publishes on /rosout what the nodes of one context log."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._outlets: dict[str, list[_Outlet]] = {}
        """The outlets by logger name; the first outlet of each name has the publisher."""
        self._ways: dict[str, Callable[[bytes], None]] = {}
        self._sink: SinkHandle | None = None

    def join(self, node: LoggingNode, qos: QoS = ROSOUT) -> None:
        """Publish the log of `node`, until it is destroyed."""
        outlet = _Outlet(self, node, qos)
        with self._lock:
            fellows = self._outlets.setdefault(outlet.name, [])
            fellows.append(outlet)
            if self._sink is None:
                self._sink = add_sink(self._take)
        node.own(outlet)
        node.remains.add(outlet.forget)
        if fellows[0] is outlet:
            self._ways[outlet.name] = outlet.open()
        else:
            get_logger('rcl.logging_rosout').warning(
                f"Publisher already registered for node name: '{outlet.name}'. If this is due to multiple "
                f"nodes with the same name then all logs for the logger named '{outlet.name}' will go out "
                'over the existing publisher.'
            )

    def discard(self, outlet: _Outlet) -> None:
        """Forget a node's outlet; the next outlet of its logger's name takes over."""
        name = outlet.name
        with self._lock:
            fellows = self._outlets.get(name, [])
            if outlet not in fellows:
                return
            was_first = fellows[0] is outlet
            fellows.remove(outlet)
            # The next outlet of this name takes over, even if this call comes from a line that is dropped
            heir = fellows[0] if was_first and fellows else None
            if not fellows:
                del self._outlets[name]
        if heir is not None:
            with suppress(ClosedError):  # the context has ended: nothing can be published
                self._ways[name] = heir.open()
                return
        if was_first:
            self._ways.pop(name, None)

    def close(self) -> None:
        """Stop publishing: the context ends. Idempotent."""
        with self._lock:
            sink, self._sink = self._sink, None
            self._outlets.clear()
        self._ways.clear()
        if sink is not None:
            sink.close()

    def _take(self, record: LogRecord) -> None:
        publish = self._ways.get(record.name) or self._ways.get(record.origin)
        if publish is None:
            return
        try:
            publish(encode_log(record))
        except (ClosedError, ForkedError):
            return  # the line came too late, or from a child process: other outlets are open


class _Outlet:
    """One node's claim to publish the log lines under `name`."""

    def __init__(self, hub: Rosout, node: LoggingNode, qos: QoS) -> None:
        self.name = node.logger_name
        self.support = standard_message(LOG)
        self._hub = hub
        self._node = ref(node)  # weakly: the hub must not keep the node alive
        self.forget = partial(hub.discard, self)
        self._qos = qos
        self._port: PublisherPort | None = None

    def open(self) -> Callable[[bytes], None]:
        """Declare the publisher and return its publish function; raises ClosedError if the node has gone."""
        node = self._node()
        if node is None:
            raise ClosedError(f"the node of the logger '{self.name}' was dropped")
        endpoint = describe_endpoint(
            node, EndpointKind.PUBLISHER, node.resolve(TOPIC), self.support, self._qos, waits_for_room=False
        )
        self._port = node.port.publisher(endpoint)
        return self._port.publish

    def destroy(self) -> None:
        """Undeclare the publisher. Idempotent."""
        node = self._node()
        if node is not None:
            node.disown(self)
            node.remains.discard(self.forget)
        self._hub.discard(self)
        port, self._port = self._port, None
        if port is not None:
            port.close()


def encode_log(record: LogRecord) -> bytes:
    """Return a record as a serialized rcl_interfaces/msg/Log.

    The bytes are written by hand: to make the message class would delay a program's first line a hundredfold.
    Characters that a ROS string cannot hold are spelt out: a line is never lost.
    """
    seconds, nanoseconds = divmod(min(record.stamp_ns, LATEST_STAMP), S_TO_NS)
    data = bytearray(_HEAD.pack(b'\0\1\0\0', seconds, nanoseconds, record.severity))
    for text in (record.name, record.message, record.file, record.function):
        encoded = text.encode(errors='backslashreplace').replace(b'\0', b'\\x00') + b'\0'
        data += b'\0' * (-len(data) & 3) + _NUMBER.pack(len(encoded)) + encoded
    return bytes(data + b'\0' * (-len(data) & 3) + _NUMBER.pack(record.line))
