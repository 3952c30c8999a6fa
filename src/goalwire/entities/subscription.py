"""A subscription: queues messages as they arrive, decodes them on the executor's thread, calls back."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, TypedDict

from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import MessageSupport, MsgT, message_support
from goalwire.errors import InvalidHandle, RemoteError
from goalwire.execution.callback_arguments import accepts, describe_given
from goalwire.execution.callback_groups import CallbackGroup, ReentrantCallbackGroup
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.future import Future, block_on
from goalwire.execution.time.steady_clock import deadline_after
from goalwire.fault_reports import log_rejected
from goalwire.records import replace
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind, Payload, Port, Sample
from goalwire.transport.registry import select_identifier

if TYPE_CHECKING:
    from goalwire.entities.qos_events import EndpointEvents
    from goalwire.rules.statistics import SubscriptionStatistics

_DEFAULT_DEPTH = 42
"""The depth that rmw_zenoh uses if 0 is given."""


class PublisherGid(TypedDict):
    """The publisher of a message, in the form of rclpy of ROS 2 Lyrical."""

    implementation_identifier: str
    """The wire, as RMW_IMPLEMENTATION spells it."""
    data: bytes
    """16 bytes, the `endpoint_gid` of `get_publishers_info_by_topic`."""


class MessageInfo(TypedDict):
    """The second argument of a two-argument callback; times in ns since the UNIX epoch.

    Publications are numbered from 1 by their publisher, receptions from 0 by the subscription; on DDS both
    are None.
    """

    source_timestamp: int
    received_timestamp: int
    publication_sequence_number: int | None
    reception_sequence_number: int | None
    publisher_gid: PublisherGid


class SubscriptionCore(Generic[MsgT]):
    """Receives messages of one type on one topic; `raw` hands out the serialized bytes."""

    def __init__(
        self,
        node: NodeCore,
        msg_type: type[MsgT] | MessageSupport,
        topic: str,
        callback: Callable[..., object],
        qos: QoS,
        group: CallbackGroup,
        *,
        raw: bool = False,
        views: bool = False,
    ) -> None:
        """With `views`, sequences of numbers are read-only views of the received bytes, and so is what `raw`
        gives.
        """
        self.node = node
        self.topic = topic
        self.qos = qos
        self.raw = raw
        self.taken = 0
        """How many messages the callback got, or `take` returned."""
        self.rejected = 0
        """How many messages could not be decoded; none of them reached the callback."""
        self.support = msg_type if isinstance(msg_type, MessageSupport) else message_support(msg_type)
        self._decode: Callable[..., Any] = self._choose_decoder(views=views)
        self.set_callback(callback)
        self.full_name = node.resolve(topic)
        self.event_queue: EventQueue[Sample] = EventQueue(
            node.work_queue, group, self._handle, depth=queue_depth(qos)
        )
        endpoint = describe_endpoint(node, EndpointKind.SUBSCRIPTION, self.full_name, self.support, qos)
        if views:
            endpoint = replace(endpoint, takes_views=True)
        self._endpoint = endpoint
        self._events: EndpointEvents | None = None
        self._port: Port | None = node.port.subscription(endpoint, self._receiver())
        node.own(self)

    @cached_property
    def msg_type(self) -> type[MsgT]:
        """The message class."""
        return self.support.cls

    def _choose_decoder(self, *, views: bool) -> Callable[..., Any]:
        if self.raw:
            return _view if views else bytes
        return self.support.decode_in_place if views else self.support.decode

    def set_callback(self, callback: Callable[..., object]) -> None:
        """Take another callback of one argument (message) or two (message, MessageInfo).

        Raises RuntimeError, with rclpy's words, for anything else.
        """
        self._wants_info = _takes_info(callback)
        self._callback = callback

    def _receiver(self) -> Callable[[Sample], None]:
        """Return the function that the transport calls with each message: the event queue's own method, which
        saves a call.
        """
        return self.event_queue.deliver

    def _handle(self, sample: Sample) -> object:
        try:
            message = self._decode(sample.payload)
        except RemoteError as error:
            self._reject(error)
            return None
        taken = self.taken
        self.taken = taken + 1
        if self._wants_info:
            return self._callback(message, _info(sample, taken))
        return self._callback(message)

    def take(self) -> tuple[Any, MessageInfo] | None:
        """Take the oldest waiting message, without the callback; None if there is none.

        Raises InvalidHandle once destroyed.
        """
        if self._port is None:
            raise InvalidHandle
        while (sample := self.event_queue.take()) is not None:
            taken = self.read(sample)
            if taken is not None:
                return taken
        return None

    def read(self, sample: Sample) -> tuple[Any, MessageInfo] | None:
        """Return the message of a sample; None if it cannot be decoded, which is counted and logged."""
        try:
            message = self._decode(sample.payload)
        except RemoteError as error:
            self._reject(error)
            return None
        taken = self.taken
        self.taken = taken + 1
        return message, _info(sample, taken)

    def _reject(self, error: RemoteError) -> None:
        self.rejected += 1
        what = f"Topic '{self.full_name}': a message was rejected"
        log_rejected(self.node.logger_name, what, self.rejected, error, is_error=True)

    def publisher_count(self) -> int:
        """How many publishers match: of this type, and with a QoS that is compatible with this
        subscription's.

        Raises InvalidHandle once destroyed.
        """
        if self._port is None:
            raise InvalidHandle
        count = self._port.peer_count()
        return len(self.node.graph.find_matched(self._endpoint)) if count is None else count

    @property
    def events(self) -> EndpointEvents:
        """The QoS events of this subscription; raises InvalidHandle once destroyed."""
        if self._port is None:
            raise InvalidHandle
        if self._events is None:
            from goalwire.entities.qos_events import EndpointEvents

            self._events = EndpointEvents(self.node, self._endpoint, self._port, self._watch_arrivals)
        return self._events

    def _watch_arrivals(self, note: Callable[[Sample], None]) -> None:
        self.event_queue.note = note

    def statistics(self) -> SubscriptionStatistics:
        """Return the counts of received messages."""
        return self._count(len(self.event_queue), self.event_queue.dropped)

    def _count(self, waiting: int, dropped: int) -> SubscriptionStatistics:
        from goalwire.rules.statistics import SubscriptionStatistics

        return SubscriptionStatistics(self.full_name, self.taken, waiting, dropped, self.rejected)

    @property
    def destroyed(self) -> bool:
        """True once the subscription is destroyed."""
        return self._port is None

    def destroy(self) -> None:
        """Undeclare the subscription. Queued messages are not delivered. Idempotent."""
        port, self._port = self._port, None
        if port is not None:
            self.node.disown(self)
            if self._events is not None:
                self._events.close()
            port.close()
            self.event_queue.close()


def _view(payload: Payload) -> memoryview:
    return memoryview(payload).toreadonly()


def queue_depth(qos: QoS) -> int | None:
    """Return how many messages may wait for a subscription; None for any number."""
    return None if qos.keeps_all else qos.depth or _DEFAULT_DEPTH


def _info(sample: Sample, taken: int) -> MessageInfo:
    """Return the MessageInfo of a message; `taken` messages were taken before it. rmw_zenoh counts receptions
    from 0; on DDS, which does not number messages, both numbers are None.
    """
    return {
        'source_timestamp': sample.source_timestamp,
        'received_timestamp': sample.received_timestamp,
        'publication_sequence_number': sample.sequence or None,
        'reception_sequence_number': taken if sample.sequence else None,
        'publisher_gid': {'implementation_identifier': select_identifier(), 'data': sample.gid},
    }


def _takes_info(callback: object) -> bool:
    for count in (1, 2):
        if callable(callback) and accepts(callback, count):
            return count == 2
    wanted = 'the callback of a subscription is a function that is callable with one argument, the message'
    if not callable(callback):
        raise RuntimeError(f'{wanted}: {describe_given(callback)}')  # noqa: TRY004 - rclpy's
    name = getattr(callback, '__name__', repr(callback))
    better = 'lambda message: …' if name == '<lambda>' else f'def {name}(message):'
    raise RuntimeError(
        f"{wanted}, or with two, the message and its info; {name} takes another number: write '{better}'"
    )


def wait_for_message(
    node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS, timeout_sec: float
) -> MsgT | None:
    """Return the next message, or None at the end of the time (negative: without limit) or of the context.

    It makes a subscription of its own, which no executor serves. So it works inside callbacks, and while
    threads spin. Raises what making a subscription raises.
    """
    clock = node.context.shutdown_signal.clock
    subscription = _Awaited(node, msg_type, topic, qos)
    try:
        return subscription.receive(deadline_after(clock, timeout_sec))
    finally:
        subscription.destroy()


class _Awaited(SubscriptionCore[MsgT]):
    """Keeps the arriving messages for the thread that waits."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS) -> None:
        self._samples: deque[Sample] = deque(maxlen=max(qos.depth, 1))
        self._arrival: Future[None] = Future()
        super().__init__(node, msg_type, topic, _refuse_call, qos, ReentrantCallbackGroup())

    def _receiver(self) -> Callable[[Sample], None]:
        return self._deliver

    def _deliver(self, sample: Sample) -> None:
        self._samples.append(sample)
        self._arrival.set_result(None)

    def receive(self, deadline: int | None) -> MsgT | None:
        """Wait for a message that can be decoded; None at `deadline` (steady ns) or the context's end."""
        while block_on(self._arrival, deadline, self.node.context.shutdown_signal):
            self._arrival = Future()  # first: a message that comes from now on completes the new future
            while self._samples:
                sample = self._samples.popleft()
                try:
                    message: MsgT = self._decode(sample.payload)
                except RemoteError as error:
                    self._reject(error)
                else:
                    return message
        return None


def _refuse_call(_message: object) -> None:
    raise AssertionError('messages that are waited for reach no executor')
