"""rclpy.event_handler: callbacks for the events of a publisher or subscription.

goalwire.entities.qos_events detects these events.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from goalwire.entities.publisher import PublisherCore
from goalwire.entities.qos_events import default_callback
from goalwire.errors import InvalidHandle, UnsupportedEventTypeError
from goalwire.execution.wait_sets.waitable import NumberOfEntities, SelfDriven
from goalwire.rules.qos_events import (
    EventStatus,
    EventType,
    IncompatibleQoS,
    IncompatibleType,
    LivelinessChanged,
    LivelinessLost,
    Matched,
    MessageLost,
    OfferedDeadlineMissed,
    PublisherEvent,
    RequestedDeadlineMissed,
    SubscriptionEvent,
)
from rclpy._reexports import reexport

if TYPE_CHECKING:
    from goalwire.entities.subscription import SubscriptionCore
    from goalwire.execution.wait_sets.waitable import WaitSet
    from rclpy.callback_groups import CallbackGroup

__all__ = [
    'EventHandler',
    'IncompatibleTypeInfo',
    'PublisherEventCallbacks',
    'QoSEventHandler',
    'QoSLivelinessChangedInfo',
    'QoSLivelinessLostInfo',
    'QoSMessageLostInfo',
    'QoSOfferedDeadlineMissedInfo',
    'QoSOfferedIncompatibleQoSInfo',
    'QoSPublisherEventType',
    'QoSPublisherMatchedInfo',
    'QoSRequestedDeadlineMissedInfo',
    'QoSRequestedIncompatibleQoSInfo',
    'QoSSubscriptionEventType',
    'QoSSubscriptionMatchedInfo',
    'SubscriptionEventCallbacks',
    'UnsupportedEventTypeError',
]

QoSPublisherEventType = PublisherEvent
QoSSubscriptionEventType = SubscriptionEvent
QoSRequestedDeadlineMissedInfo = RequestedDeadlineMissed
QoSLivelinessChangedInfo = LivelinessChanged
QoSMessageLostInfo = MessageLost
QoSRequestedIncompatibleQoSInfo = IncompatibleQoS
QoSSubscriptionMatchedInfo = Matched
QoSOfferedDeadlineMissedInfo = OfferedDeadlineMissed
QoSLivelinessLostInfo = LivelinessLost
QoSPublisherMatchedInfo = Matched
QoSOfferedIncompatibleQoSInfo = IncompatibleQoS
IncompatibleTypeInfo = IncompatibleType

_Endpoint: TypeAlias = 'PublisherCore[Any] | SubscriptionCore[Any]'
_Callback: TypeAlias = Callable[[Any], object]


class EventHandler(SelfDriven[EventStatus | None]):
    """One callback for one kind of event.

    The callback is plain or `async def`, and runs in its callback group.
    """

    def __init__(
        self,
        *,
        callback_group: CallbackGroup,
        callback: _Callback,
        event_type: EventType,
        parent_impl: _Endpoint,
    ) -> None:
        """Raises UnsupportedEventTypeError if the wire lacks the event, TypeError for a wrong endpoint."""
        self.event_type = event_type
        self._reader = parent_impl.events.reader(event_type, callback_group, callback)
        self._index: int | None = None
        super().__init__(callback_group)

    @property
    def callback(self) -> _Callback:
        """The callback, which gets each status of the event."""
        return self._reader.callback

    @callback.setter
    def callback(self, value: _Callback) -> None:
        self._reader.callback = value

    def is_ready(self, wait_set: WaitSet) -> bool:
        """Return whether the event is ready in the wait set to which it was added."""
        return self._index is not None and wait_set.is_ready('event', self._index)

    def take_data(self) -> EventStatus | None:
        """Take the event's status with the changes since the last status taken; None without changes."""
        self._check_alive()
        return self._reader.take()

    async def execute(self, taken_data: EventStatus | None) -> None:
        """Call the callback with the status that `take_data` returned."""
        from rclpy.executors import await_or_execute

        if taken_data is not None:
            await await_or_execute(self.callback, taken_data)

    def get_num_entities(self) -> NumberOfEntities:
        """Return the numbers of entities: one event."""
        return NumberOfEntities(num_events=1)

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        """Add the event to `wait_set`."""
        self._check_alive()
        self._index = wait_set.add_event(self._reader)

    def __enter__(self) -> None:
        self._check_alive()

    def destroy(self) -> None:
        """Stop handling the event: its callback is not called any more. Idempotent."""
        self._reader.close()

    def _check_alive(self) -> None:
        if self._reader.closed:
            raise InvalidHandle


class QoSEventHandler(EventHandler):
    """Another name for EventHandler, which ROS 2 has deprecated."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        warnings.warn(
            'QoSEventHandler is deprecated, use EventHandler instead.', DeprecationWarning, stacklevel=2
        )
        super().__init_subclass__(**kwargs)

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        warnings.warn(
            'QoSEventHandler is deprecated, use EventHandler instead.', DeprecationWarning, stacklevel=2
        )
        super().__init__(*args, **kwargs)


class SubscriptionEventCallbacks:
    """The callbacks for a subscription's events.

    If the program sets no callbacks for incompatible QoS and types, these are logged as warnings, unless
    `use_default_callbacks` is false.
    """

    def __init__(
        self,
        *,
        deadline: Callable[[RequestedDeadlineMissed], object] | None = None,
        incompatible_qos: Callable[[IncompatibleQoS], object] | None = None,
        liveliness: Callable[[LivelinessChanged], object] | None = None,
        message_lost: Callable[[MessageLost], object] | None = None,
        incompatible_type: Callable[[IncompatibleType], object] | None = None,
        matched: Callable[[Matched], object] | None = None,
        use_default_callbacks: bool = True,
    ) -> None:
        self.deadline = deadline
        self.incompatible_qos = incompatible_qos
        self.liveliness = liveliness
        self.message_lost = message_lost
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks

    def create_event_handlers(
        self, callback_group: CallbackGroup, subscription: SubscriptionCore[Any], topic_name: str
    ) -> list[EventHandler]:
        """Return a handler for each callback; raises UnsupportedEventTypeError if the wire cannot tell."""
        return list(_handlers(self, _SUBSCRIPTION_EVENTS, callback_group, subscription, topic_name))


class PublisherEventCallbacks:
    """The callbacks for a publisher's events, with the same defaults as SubscriptionEventCallbacks."""

    def __init__(
        self,
        *,
        deadline: Callable[[OfferedDeadlineMissed], object] | None = None,
        liveliness: Callable[[LivelinessLost], object] | None = None,
        incompatible_qos: Callable[[IncompatibleQoS], object] | None = None,
        incompatible_type: Callable[[IncompatibleType], object] | None = None,
        matched: Callable[[Matched], object] | None = None,
        use_default_callbacks: bool = True,
    ) -> None:
        self.deadline = deadline
        self.liveliness = liveliness
        self.incompatible_qos = incompatible_qos
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks

    def create_event_handlers(
        self, callback_group: CallbackGroup, publisher: PublisherCore[Any], topic_name: str
    ) -> list[EventHandler]:
        """Return a handler for each callback; raises UnsupportedEventTypeError if the wire cannot tell."""
        return list(_handlers(self, _PUBLISHER_EVENTS, callback_group, publisher, topic_name))


def event_handlers(
    endpoint: _Endpoint,
    callbacks: PublisherEventCallbacks | SubscriptionEventCallbacks | None,
    group: CallbackGroup,
) -> list[EventHandler]:
    """Return the handlers of a new publisher or subscription; None stands for the default callbacks.

    Raises UnsupportedEventTypeError if the wire cannot detect an event.
    """
    if isinstance(endpoint, PublisherCore):
        wanted = cast('PublisherEventCallbacks', callbacks or PublisherEventCallbacks())
        return wanted.create_event_handlers(group, endpoint, endpoint.topic)
    asked = cast('SubscriptionEventCallbacks', callbacks or SubscriptionEventCallbacks())
    return asked.create_event_handlers(group, endpoint, endpoint.topic)


_SUBSCRIPTION_EVENTS: dict[str, EventType] = {
    'deadline': SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED,
    'incompatible_qos': SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
    'liveliness': SubscriptionEvent.RCL_SUBSCRIPTION_LIVELINESS_CHANGED,
    'message_lost': SubscriptionEvent.RCL_SUBSCRIPTION_MESSAGE_LOST,
    'incompatible_type': SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE,
    'matched': SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED,
}
"""The names of callbacks and their events, in the order of rclpy's list of handlers."""

_PUBLISHER_EVENTS: dict[str, EventType] = {
    'deadline': PublisherEvent.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED,
    'liveliness': PublisherEvent.RCL_PUBLISHER_LIVELINESS_LOST,
    'incompatible_qos': PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
    'incompatible_type': PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE,
    'matched': PublisherEvent.RCL_PUBLISHER_MATCHED,
}


def _handlers(
    callbacks: SubscriptionEventCallbacks | PublisherEventCallbacks,
    events: dict[str, EventType],
    group: CallbackGroup,
    endpoint: _Endpoint,
    topic: str,
) -> Iterator[EventHandler]:
    for name, event in events.items():
        default = default_callback(endpoint, event, topic)
        callback = getattr(callbacks, name) or (default if callbacks.use_default_callbacks else None)
        if not callback:
            continue
        try:
            yield EventHandler(
                callback_group=group, callback=callback, event_type=event, parent_impl=endpoint
            )
        except UnsupportedEventTypeError:
            if default is None:  # as in rclpy, only default callbacks may be for events that the wire lacks
                raise


reexport(__name__)
