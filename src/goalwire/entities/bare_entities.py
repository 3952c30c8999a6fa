"""Entities without a callback, as the C extension of rclpy makes them. Programs add them to waitables and to
wait sets, and take the data themselves. No executor runs them.
"""

from __future__ import annotations

from itertools import count
from threading import RLock
from types import SimpleNamespace, TracebackType
from typing import TYPE_CHECKING, Any, Self

from goalwire.entities.client import ClientCore
from goalwire.entities.service import ServiceCore
from goalwire.entities.subscription import MessageInfo, SubscriptionCore
from goalwire.entities.type_support import MsgT, service_support
from goalwire.errors import InvalidHandle
from goalwire.execution import event_queue
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.rclpy_handle import entity_of
from goalwire.execution.ready_queue import NodeWorkQueue
from goalwire.execution.time import timer
from goalwire.rules.qos_events import EventStatus, EventType, changes_between

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from goalwire.entities.node import NodeCore
    from goalwire.entities.pending_call import PendingCall
    from goalwire.entities.qos_events import TopicEndpoint
    from goalwire.execution.shutdown_signal import ContextLike
    from goalwire.execution.time.clock import Clock
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import Request


class _BareGroup(ReentrantCallbackGroup):
    """A group whose work reaches no executor."""

    def __init__(self) -> None:
        super().__init__()
        self.work_queue = NodeWorkQueue()


class _Held:
    """A mixin for `with entity:`, which keeps the entity alive, and for the names that all entities have."""

    if TYPE_CHECKING:

        @property
        def destroyed(self) -> bool:
            """True once destroyed."""

        def destroy(self) -> None:
            """Release the entity. Idempotent."""

    def __enter__(self) -> Self:
        """Return the entity; raise InvalidHandle if it is destroyed."""
        if self.destroyed:
            raise InvalidHandle
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Do nothing: the entity lives on."""

    @property
    def pointer(self) -> int:
        """The number of this entity in `get_ready_entities` of a wait set."""
        return id(self)

    def destroy_when_not_in_use(self) -> None:
        """Destroy the entity, at once."""
        self.destroy()


class GuardCondition(_Held, event_queue.GuardCondition):
    """Wakes waitables and wait sets."""

    def __init__(self, context: ContextLike) -> None:
        super().__init__(None, None, context)

    @property
    def destroyed(self) -> bool:
        return self._destroyed

    def trigger_guard_condition(self) -> None:
        """Wake; raises InvalidHandle once destroyed."""
        self.trigger()


class Timer(_Held, timer.Timer):
    """Is ready once a period, until `call_timer`."""

    def __init__(self, clock: Clock, context: ContextLike, period_nsec: int, autostart: bool = True) -> None:
        super().__init__(None, None, period_nsec, entity_of(clock), context=context, autostart=autostart)

    @property
    def destroyed(self) -> bool:
        return self._destroyed


class Subscription(_Held, SubscriptionCore[MsgT]):
    """Keeps messages until the program takes them."""

    def __init__(self, node: NodeCore, msg_type: type[MsgT], topic: str, qos: QoS) -> None:
        super().__init__(entity_of(node), msg_type, topic, _ignore, qos, _BareGroup())

    def take_message(self, msg_type: type[MsgT], raw: bool) -> tuple[Any, MessageInfo] | None:  # noqa: ARG002
        """Take a waiting message and its info; return None if there is no message."""
        return self.take()


class Service(_Held, ServiceCore):
    """Keeps requests until the program takes and answers them."""

    def __init__(self, node: NodeCore, srv_type: type, name: str, qos: QoS) -> None:
        super().__init__(entity_of(node), service_support(srv_type), name, _ignore, qos, _BareGroup())

    def service_take_request(self, srv_request_type: type) -> tuple[Any, Request] | tuple[None, None]:  # noqa: ARG002
        """Take a waiting request and its header; return (None, None) if none waits."""
        return self.take() or (None, None)

    def service_send_response(self, response: object, header: Request) -> None:
        """Answer the request of a header."""
        self.send_response(response, header)


class _WaitingResponses:
    """The responses of a bare client, as a wait set sees them. A client without this counts all responses."""

    counts_up = False

    def __init__(self, client: Client) -> None:
        self._client = client

    @property
    def events(self) -> int:
        """The number of responses that wait to be taken."""
        return self._client.count_responses()

    @property
    def watchers(self) -> Sequence[Callable[[], None]]:
        """The functions that the client calls at each response."""
        return self._client.watchers

    @watchers.setter
    def watchers(self, watchers: Sequence[Callable[[], None]]) -> None:
        self._client.watchers = watchers


class Client(_Held, ClientCore):
    """Sends requests, and keeps responses until the program takes them. It is ready while some wait."""

    def __init__(self, node: NodeCore, srv_type: type, name: str, qos: QoS) -> None:
        self._numbers = count(1)  # the wire's own number of a call may be gone when its answer is there
        self._calls: list[tuple[int, PendingCall]] = []
        self._lock = RLock()
        """Held while a request is sent: its response may come, and be taken, before it is in `_calls`."""
        self.event_queue = _WaitingResponses(self)
        super().__init__(entity_of(node), service_support(srv_type), name, qos)

    def send_request(self, request: object) -> int:
        """Send a request, and return its number; raises as `ClientCore.begin` does."""
        with self._lock:
            self._calls = [
                (number, call) for number, call in self._calls if call.done() or not call.end_lock.locked()
            ]
            number = next(self._numbers)
            self._calls.append((number, self.begin(request, None)))
        return number

    def take_response(self, response_type: type) -> tuple[SimpleNamespace, Any] | tuple[None, None]:  # noqa: ARG002
        """Take a response and its header, which has the number as `request_id.sequence_number`; return
        (None, None) if none waits.
        """
        with self._lock:
            for index, (number, call) in enumerate(self._calls):
                if call.done():
                    del self._calls[index]
                    return SimpleNamespace(request_id=SimpleNamespace(sequence_number=number)), call.result()
        return None, None

    def count_responses(self) -> int:
        """Return how many responses wait to be taken."""
        with self._lock:
            return sum(call.done() for _, call in self._calls)

    def service_server_is_available(self) -> bool:
        """Tell whether there is a server that can be called."""
        return self.server_is_there()


class EventHandle(_Held):
    """One kind of QoS event of a publisher or subscription."""

    def __init__(self, endpoint: TopicEndpoint, event_type: EventType) -> None:
        """Raises UnsupportedEventTypeError if the wire lacks the event, TypeError for a wrong endpoint."""
        self._source = endpoint.events
        self.event_queue = self._source.reader(event_type, _BareGroup(), _ignore)

    @property
    def destroyed(self) -> bool:
        return self.event_queue.closed

    def destroy(self) -> None:
        self.event_queue.close()

    def take_event(self) -> EventStatus:
        """Return the event's status with the changes since it was last taken."""
        changes = self.event_queue.take()
        if changes is None:
            status = self._source.status(self.event_queue.event)
            return changes_between(status, status)
        return changes


def _ignore(*_: object) -> None:
    """The callback of entities without one: no executor calls it."""
