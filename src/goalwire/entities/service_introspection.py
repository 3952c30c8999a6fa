"""Service events: each step of a call, on `<service>/_service_event` (rcl's service_introspection)."""

from __future__ import annotations

from enum import Enum, IntEnum
from threading import RLock
from typing import TYPE_CHECKING, Any, Protocol

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.type_support import message_support
from goalwire.errors import ClosedError, GoalwireError, InvalidHandle
from goalwire.logging import get_logger
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ServiceSupport
    from goalwire.execution.time.clock import Clock
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import Payload, Sample

POSTFIX = '/_service_event'


class ServiceIntrospectionState(IntEnum):
    """Which events of a client's or service's calls are published."""

    __str__ = Enum.__str__

    OFF = 0
    METADATA = 1
    CONTENTS = 2


class Step(IntEnum):
    """One step of a call (service_msgs/msg/ServiceEventInfo)."""

    REQUEST_SENT = 0
    REQUEST_RECEIVED = 1
    RESPONSE_SENT = 2
    RESPONSE_RECEIVED = 3


class Closable(Protocol):
    """The watch for recorders (recorder_watch.py), as far as its owner needs it."""

    def close(self) -> None:
        """Stop publishing. Idempotent."""


class Introspected:
    """Mixed into clients and services."""

    node: NodeCore
    support: ServiceSupport
    full_name: str
    introspection: ServiceIntrospection | None = None
    """The publisher of service events in use; None while nothing is published."""
    configured: ServiceIntrospection | None = None
    """The publisher of service events, if the program has switched them on."""
    recorded: ServiceIntrospection | None = None
    """The publisher that a recorder asked for; the program's own comes before it."""
    recorder_watch: Closable | None = None

    def introspect(self, clock: Clock, qos: QoS, state: ServiceIntrospectionState) -> None:
        """Publish the steps of calls from now on, stamped by `clock`, or stop that.

        Raises TypeError for what is not a state, InvalidHandle once destroyed.
        """
        if not isinstance(state, ServiceIntrospectionState):
            raise TypeError(f'{state!r} is not a ServiceIntrospectionState')
        if self.destroyed:
            raise InvalidHandle
        self._end_configured()
        if state is not ServiceIntrospectionState.OFF:
            contents = state is ServiceIntrospectionState.CONTENTS
            self.configured = ServiceIntrospection(self, clock, qos, contents=contents)
            self.choose_reporter()

    @property
    def destroyed(self) -> bool:
        """True once the client or service is destroyed."""
        raise NotImplementedError

    def choose_reporter(self) -> None:
        """Choose where calls are reported: to the program's publisher, a recorder's, or nowhere."""
        self.introspection = self.configured or self.recorded

    def _end_configured(self) -> None:
        current, self.configured = self.configured, None
        self.choose_reporter()
        if current is not None:
            current.close()

    def end_introspection(self) -> None:
        """Stop publishing service events, and do not begin again. Idempotent."""
        self._end_configured()
        watch, self.recorder_watch = self.recorder_watch, None
        if watch is not None:
            watch.close()


class ServiceIntrospection:
    """Publishes the events of one client or service. Failures here are logged and harm no call."""

    def __init__(
        self, owner: Introspected, clock: Clock, qos: QoS, *, contents: bool, postfix: str = POSTFIX
    ) -> None:
        node, self._support = owner.node, owner.support
        event: type = self._support.cls.Event  # type: ignore[attr-defined]  # it is a service class
        support = message_support(event)
        self._event: type[Any] = event
        self._encode = support.encode
        self._clock = clock
        self._contents = contents
        self._logger_name = node.logger_name
        self._failed = False
        self.topic = node.resolve(owner.full_name + postfix)
        # The publisher never waits: the transport's own threads publish some events.
        endpoint = describe_endpoint(
            node, EndpointKind.PUBLISHER, self.topic, support, qos, waits_for_room=False
        )
        self._port = node.port.publisher(endpoint)
        self.order = RLock()
        """Held while steps are noted whose order matters; re-entrant, for a signal handler may call, too."""
        self._dispatcher: OrderedDispatcher[bytes] = OrderedDispatcher(self._port.publish)

    def report(self, step: Step, gid: bytes, sequence: int, message: object = None) -> None:
        """Publish one step of the call that the client `gid` counts as `sequence`."""
        self.note(step, gid, sequence, message)
        self.flush()

    def note(self, step: Step, gid: bytes, sequence: int, message: object = None) -> None:
        """Queue one step to be published."""
        try:
            self._dispatcher.post(self._event_of(step, gid, sequence, message))
        except GoalwireError as error:
            self._complain(error)

    def flush(self) -> None:
        """Publish the waiting events."""
        try:
            self._dispatcher.drain()
        except ClosedError:
            return  # the context, node or entity is ending
        except GoalwireError as error:
            self._complain(error)

    def decode_request(self, payload: Payload) -> object:
        """Return the request in a payload; None if contents are not published, or cannot be decoded."""
        return self._decode(self._support.decode_request, payload)

    def decode(self, payload: Payload) -> object:
        """Return the response in a payload; None if contents are not published, or cannot be decoded."""
        return self._decode(self._support.decode_response, payload)

    def _decode(self, decode: Callable[[Payload], object], payload: Payload) -> object:
        try:
            return decode(payload) if self._contents else None
        except GoalwireError:
            return None  # whoever reads the message gets the error

    def _event_of(self, step: Step, gid: bytes, sequence: int, message: object) -> bytes:
        event = self._event()
        info = event.info
        info.event_type = step
        info.stamp = self._clock.now().to_stamp()
        info.client_gid = gid
        info.sequence_number = sequence
        if self._contents and message is not None:
            if step in (Step.REQUEST_SENT, Step.REQUEST_RECEIVED):
                event.request = [message]
            else:
                event.response = [message]
        return self._encode(event)

    def _complain(self, error: GoalwireError) -> None:
        if not self._failed:
            self._failed = True
            get_logger(self._logger_name).error(
                f"Topic '{self.topic}': an event was not published ({error}); later failures are not shown"
            )

    def close(self) -> None:
        """Undeclare the publisher."""
        self._port.close()


class IntrospectedCall:
    """One call as its client sees it. Within one process the reply may come before the request's number is
    known.
    """

    __slots__ = ('_gid', '_introspection', '_request')

    def __init__(self, introspection: ServiceIntrospection, gid: bytes, request: object) -> None:
        self._introspection = introspection
        self._gid = gid
        self._request: list[object] = [request]

    def report_request(self, sequence: int) -> None:
        """Report that the request went out."""
        with self._introspection.order:
            self._note_request(sequence)
        self._introspection.flush()

    def report_response(self, sample: Sample) -> None:
        """Report the response, and the request before it."""
        introspection = self._introspection
        response = introspection.decode(sample.payload)
        with introspection.order:
            self._note_request(sample.sequence)
            introspection.note(Step.RESPONSE_RECEIVED, self._gid, sample.sequence, response)
        introspection.flush()

    def _note_request(self, sequence: int) -> None:
        if self._request:
            self._introspection.note(Step.REQUEST_SENT, self._gid, sequence, self._request.pop())
