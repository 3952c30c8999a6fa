"""A publisher: encodes a message and hands it to the wire."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Generic, cast

from goalwire.cdr import codec
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.message_type_errors import explain_wrong_message
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import MessageSupport, MsgT, message_support
from goalwire.errors import ClosedError, InvalidHandle
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind, PublisherPort

if TYPE_CHECKING:
    from goalwire.entities.late_joiner_warnings import LateJoiners
    from goalwire.entities.loans import LoanedMessage
    from goalwire.entities.qos_events import EndpointEvents
    from goalwire.rules.statistics import PublisherStatistics


class PublisherCore(Generic[MsgT]):
    """Publishes messages of one type on one topic."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT] | MessageSupport, topic: str, qos: QoS) -> None:
        """With a MessageSupport the class and its codec are made when they are needed."""
        self.node = node
        self.topic = topic
        self.qos = qos
        if isinstance(msg_type, MessageSupport):
            self.support = msg_type
        else:
            self.support = message_support(msg_type)
        self.full_name = node.resolve(topic)
        endpoint = describe_endpoint(node, EndpointKind.PUBLISHER, self.full_name, self.support, qos)
        self._endpoint = endpoint
        self._published = [0]
        """How many messages were handed to the wire. An item of a list is counted up twice as fast as an
        attribute.
        """
        self._dropped = 0
        """How many messages the port had dropped when it was closed."""
        self._events: EndpointEvents | None = None
        self._late_joiners: LateJoiners | None = None
        self._port: PublisherPort | None = node.port.publisher(endpoint)
        self._send: Callable[[bytes], None] = self._port.publish
        if not isinstance(msg_type, MessageSupport):
            self._encode  # noqa: B018  # made now, so that the first publish is not slow
        node.own(self)

    @cached_property
    def msg_type(self) -> type[MsgT]:
        """The message class."""
        return self.support.cls

    @cached_property
    def _encode(self) -> Callable[[object], bytes]:
        port, cls = self._port, self.support.cls
        if port is None or not port.can_lend or not codec.has_numbers(cls):
            return self.support.encode
        # The return type leaves Parts out, because only ports that can lend get them, and pass them on.
        return cast('Callable[[object], bytes]', codec.payload_encoder(cls))

    def publish(self, msg: MsgT | bytes | LoanedMessage[MsgT]) -> None:
        """Send a message, one that is serialized already, or a loaned one, which ends with that.

        Raises TypeError for another type, EncodeError if a field cannot go on the wire, InvalidHandle
        once destroyed, ShutDownError after the context's end.
        """
        try:
            if msg.__class__ is self.msg_type:
                self._send(self._encode(msg))
            elif isinstance(msg, bytes):
                self._send(msg)
            else:
                self._publish_other(msg)
            self._published[0] += 1
        except ClosedError:
            if self._port is None:
                raise self._destroyed_error() from None
            raise self.node.context.shutdown_signal.end_error(
                f"cannot publish on '{self.full_name}'"
            ) from None

    def _destroyed_error(self) -> InvalidHandle:
        """Make the error for a publication after the publisher or its node was destroyed."""
        call = 'destroy_node() of its node' if self.node.destroyed else 'destroy_publisher()'
        return InvalidHandle(
            f"cannot publish on '{self.full_name}' because destruction was requested: "
            f'{call} was called before; call publish() before that'
        )

    def can_loan_messages(self) -> bool:
        """Whether loaned messages may save a copy: the type has a sequence of numbers, and the wire has
        memory to lend.

        If subscribers cannot read the memory, loaned messages are published all the same, by copying.
        """
        from goalwire.entities.loans import loanable_fields

        port = self._port
        return port is not None and port.can_lend and bool(loanable_fields(self.msg_type))

    def borrow_loaned_message(self, **lengths: int) -> LoanedMessage[MsgT]:
        """Return a message with one sequence of numbers of this length in memory that subscribers read.

        `borrow_loaned_message(data=1_000_000).get().data` is a writable memoryview, until the message is
        published or its `with` block ends. Without such memory it is a memoryview as well, and is copied.
        Raises TypeError for a field that is not a sequence of numbers, InvalidHandle once destroyed.
        """
        from goalwire.entities.loans import borrow

        if self._port is None:
            raise self._destroyed_error()
        return borrow(self._port, self.msg_type, lengths)

    def _publish_other(self, msg: object) -> None:
        if self._port is None:
            raise self._destroyed_error()
        loaned = sys.modules.get('goalwire.entities.loans')  # imported already if there is a loan
        if loaned is not None and isinstance(msg, loaned.LoanedMessage):
            loaned.publish(self._port, msg)
            return
        if not isinstance(msg, self.msg_type):
            raise TypeError(explain_wrong_message(self.msg_type, msg))
        self._send(self._encode(msg))

    def subscription_count(self) -> int:
        """How many subscriptions match: of this type, and with a QoS that is compatible with this
        publisher's.

        Raises InvalidHandle once destroyed.
        """
        if self._port is None:
            raise InvalidHandle
        count = self._port.peer_count()
        return len(self.node.graph.find_matched(self._endpoint)) if count is None else count

    def show_liveliness(self) -> None:
        """Assert that the publisher is alive; raises InvalidHandle once destroyed."""
        if self._port is None:
            raise InvalidHandle
        self._port.assert_liveliness()

    def wait_for_acknowledgements(self, timeout_ns: int | None) -> bool:
        """Wait until all reliable subscriptions have received every published message; see PublisherPort.

        Raises InvalidHandle once destroyed.
        """
        if self._port is None:
            raise InvalidHandle
        return self._port.wait_for_acknowledgements(timeout_ns)

    @property
    def events(self) -> EndpointEvents:
        """The QoS events of this publisher; raises InvalidHandle once destroyed."""
        if self._port is None:
            raise InvalidHandle
        if self._events is None:
            from goalwire.entities.qos_events import EndpointEvents

            self._events = EndpointEvents(self.node, self._endpoint, self._port)
        return self._events

    def tell_late_joiners(self) -> None:
        """Warn if a subscription comes after the last message and waits for it in vain."""
        from goalwire.entities.late_joiner_warnings import LateJoiners

        if self._port is not None:
            self._late_joiners = LateJoiners(self.node, self._endpoint, self._published)
            self._send = self._send_first

    def _send_first(self, payload: bytes) -> None:
        """Send the first message. The later ones go to the wire directly."""
        port = self._port
        if port is None:
            raise InvalidHandle
        if self._late_joiners is not None:
            self._late_joiners.on_first_message()
        self._send = port.publish
        port.publish(payload)

    def statistics(self) -> PublisherStatistics:
        """Return the counts of published messages."""
        from goalwire.rules.statistics import PublisherStatistics

        port = self._port
        dropped = self._dropped if port is None else port.dropped
        return PublisherStatistics(self.full_name, self._published[0], dropped)

    @property
    def destroyed(self) -> bool:
        """True once the publisher is destroyed."""
        return self._port is None

    def destroy(self) -> None:
        """Undeclare the publisher. Idempotent."""
        port, self._port = self._port, None
        if port is not None:
            self._send = _refuse
            self.node.disown(self)
            if self._events is not None:
                self._events.close()
            if self._late_joiners is not None:
                self._late_joiners.close()
            port.close()
            self._dropped = port.dropped


def _refuse(_payload: bytes) -> None:
    raise InvalidHandle
