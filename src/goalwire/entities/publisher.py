"""A publisher: encodes a message and hands it to the wire."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from goalwire.entities.exceptions import InvalidHandle, ShutDownError
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import message_support
from goalwire.errors import ClosedError
from goalwire.protocol.qos import QoS
from goalwire.transport.contract import Endpoint, EndpointKind, PublisherPort

MsgT = TypeVar('MsgT')


class PublisherCore(Generic[MsgT]):
    """Publishes messages of one type on one topic."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS) -> None:
        self.node = node
        self.msg_type = msg_type
        self.topic = topic
        self.qos = qos
        self.support = message_support(msg_type)
        self.full_name = node.resolve(topic)
        self._encode = self.support.encode
        endpoint = Endpoint(
            EndpointKind.PUBLISHER,
            self.full_name,
            self.support.type_name,
            self.support.type_hash,
            qos,
            self.support.has_buffers,
        )
        self._port: PublisherPort | None = node.port.publisher(endpoint)
        self._send: Callable[[bytes], None] = self._port.publish
        node.own(self)

    def publish(self, msg: MsgT | bytes) -> None:
        """Send a message, or one that is serialized already.

        Raises TypeError for another type, EncodeError where a field cannot go on the wire, InvalidHandle
        once destroyed, ShutDownError after the context's end.
        """
        try:
            if msg.__class__ is self.msg_type:
                self._send(self._encode(msg))
            elif isinstance(msg, bytes):
                self._send(msg)
            else:
                self._publish_other(msg)
        except ClosedError:
            if self._port is None:
                raise InvalidHandle from None
            raise ShutDownError(f"cannot publish on '{self.full_name}'") from None

    def _publish_other(self, msg: object) -> None:
        if self._port is None:
            raise InvalidHandle
        if not isinstance(msg, self.msg_type):
            raise TypeError(f'Expected {self.msg_type}, got {type(msg)}')
        self._send(self._encode(msg))

    def subscription_count(self) -> int:
        """How many subscriptions the graph shows on the topic; raises InvalidHandle once destroyed."""
        if self._port is None:
            raise InvalidHandle
        return self.node.graph.count(EndpointKind.SUBSCRIPTION, self.full_name)

    @property
    def destroyed(self) -> bool:
        """True once destroyed."""
        return self._port is None

    def destroy(self) -> None:
        """Undeclare. Idempotent."""
        port, self._port = self._port, None
        if port is not None:
            self._send = _refuse
            self.node.disown(self)
            port.close()


def _refuse(_payload: bytes) -> None:
    raise InvalidHandle
