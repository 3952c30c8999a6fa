"""What is logged of an endpoint's events where the program asks for nothing, in ROS 2's words."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

from goalwire.errors import UnsupportedEventTypeError
from goalwire.logging import get_logger
from goalwire.rules.qos_events import (
    EventType,
    IncompatibleQoS,
    PublisherEvent,
    SubscriptionEvent,
    incompatible_qos_warning,
)
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.entities.publisher import PublisherCore
    from goalwire.entities.subscription import SubscriptionCore

    TopicEndpoint: TypeAlias = PublisherCore[Any] | SubscriptionCore[Any]


def default_callback(endpoint: TopicEndpoint, event: EventType, topic: str) -> Callable[[Any], object] | None:
    """Return what warns of an event, with the topic's name as it was given; None where nobody is warned."""
    warn = _WARNINGS.get(event)
    return None if warn is None else partial(warn, endpoint, event, topic)


def warn_by_default(endpoint: TopicEndpoint, topic: str) -> None:
    """Warn of all that default callbacks warn of, as far as the wire can tell."""
    publishes = endpoint.events.endpoint.kind is EndpointKind.PUBLISHER
    for event in _WARNINGS:
        if isinstance(event, PublisherEvent) is publishes:
            callback = default_callback(endpoint, event, topic)
            assert callback is not None
            with suppress(UnsupportedEventTypeError):
                endpoint.events.reader(event, None, callback)


def _warn_of_qos(endpoint: TopicEndpoint, event: EventType, topic: str, status: IncompatibleQoS) -> None:
    wire = endpoint.events.wire_that_delivers_all_the_same
    text = incompatible_qos_warning(event, topic, status.last_policy_kind, wire=wire)
    get_logger(endpoint.node.logger_name).warning(text)


def _told_by_graph(*_: object) -> None:
    """Of another type the graph warns, once for both sides, and of services and actions too."""


_WARNINGS: dict[EventType, Callable[..., None]] = {
    PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS: _warn_of_qos,
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS: _warn_of_qos,
    PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE: _told_by_graph,
    SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE: _told_by_graph,
}
