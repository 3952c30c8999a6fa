"""The part of Node that makes publishers and subscriptions."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Literal, TypeVar, overload

from goalwire.execution.callback_groups import check_group
from rclpy.callback_groups import CallbackGroup
from rclpy.impl.base_node import BaseNode
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

if TYPE_CHECKING:
    from goalwire.entities.subscription import MessageInfo
    from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
    from rclpy.qos_overriding_options import QoSOverridingOptions

MsgT = TypeVar('MsgT')


class TopicEndpoints(BaseNode):
    """The part of Node that makes and destroys publishers and subscriptions."""

    def _ros_group(self, given: CallbackGroup | None) -> CallbackGroup:
        return self._default_callback_group if given is None else check_group(given)

    def create_publisher(
        self,
        msg_type: type[MsgT],
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: PublisherEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        publisher_class: type[Publisher[Any]] = Publisher,
    ) -> Publisher[MsgT]:
        """Create a publisher; `qos_profile` is a profile or a history depth.

        Raises InvalidTopicNameException, TypeError or RuntimeError for a bad type or profile,
        UnsupportedEventTypeError for an event that the wire cannot detect, InvalidQosOverridesError.
        """
        self.handle.check_open()
        profile = self._ros_overridden(QoSProfile.of(qos_profile), 'publisher', topic, qos_overriding_options)
        group = self._ros_group(callback_group)
        publisher: Publisher[MsgT] = publisher_class(self.handle, msg_type, topic, profile.to_core())
        publisher.qos_profile = profile
        self._ros_handle_events(publisher, event_callbacks, group)
        publisher.tell_late_joiners()
        self._publishers.append(publisher)
        return publisher

    @overload
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[[MsgT], object],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: Literal[False] = False,
        views: bool = False,
    ) -> Subscription[MsgT]: ...
    @overload
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[[MsgT, MessageInfo], object],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: Literal[False] = False,
        views: bool = False,
    ) -> Subscription[MsgT]: ...
    @overload
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[[bytes], object],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: Literal[True],
        views: Literal[False] = False,
    ) -> Subscription[MsgT]: ...
    @overload
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: bool,
        views: bool = False,
    ) -> Subscription[MsgT]: ...
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: bool = False,
        views: bool = False,
    ) -> Subscription[MsgT]:
        """Create a subscription; `callback(message)` or `callback(message, info)`, plain or `async def`.

        With `raw` the callback gets serialized bytes. With `views`, sequences of numbers and serialized bytes
        are read-only memoryviews. If the message came through shared memory, the views point into this
        memory, and stay valid as long as they are referenced. Raises as create_publisher does.
        """
        self.handle.check_open()
        profile = self._ros_overridden(
            QoSProfile.of(qos_profile), 'subscription', topic, qos_overriding_options
        )
        group = self._ros_group(callback_group)
        subscription = Subscription(
            self.handle, msg_type, topic, callback, profile.to_core(), group, raw=raw, views=views
        )
        subscription.qos_profile = profile
        subscription.callback_group = group
        group.add_entity(subscription)
        self._ros_handle_events(subscription, event_callbacks, group)
        self._subscriptions.append(subscription)
        self.handle.note_callback('subscription')
        return subscription

    def _ros_overridden(
        self, profile: QoSProfile, entity: str, topic: str, options: QoSOverridingOptions | None
    ) -> QoSProfile:
        """Return the QoS profile with the overrides for this endpoint in the node's parameters."""
        if options is None:
            return profile
        from rclpy.qos_overriding_options import overridden

        return overridden(self, entity, self.handle.resolve(topic), profile, options)

    def _ros_handle_events(
        self,
        endpoint: Publisher[Any] | Subscription[Any],
        callbacks: PublisherEventCallbacks | SubscriptionEventCallbacks | None,
        group: CallbackGroup,
    ) -> None:
        """Attach the event callbacks of a new endpoint; if a callback is refused, destroy the endpoint."""
        from rclpy.event_handler import event_handlers

        try:
            endpoint.event_handlers = event_handlers(endpoint, callbacks, group)
        except BaseException:
            endpoint.destroy()
            raise
        self._ros_waitables.extend(endpoint.event_handlers)

    def destroy_publisher(self, publisher: Publisher[Any]) -> bool:
        """Destroy a publisher of this node; False if the node does not have it."""
        return destroy_owned(publisher, self._publishers) and self._ros_forget_events(publisher)

    def destroy_subscription(self, subscription: Subscription[Any]) -> bool:
        """Destroy a subscription of this node; False if the node does not have it."""
        is_ours = destroy_owned(subscription, self._subscriptions)
        is_ours = is_ours or destroy_owned(subscription, list(self.subscriptions))  # the one to /clock
        return is_ours and self._ros_forget_events(subscription)

    def _ros_forget_events(self, endpoint: Publisher[Any] | Subscription[Any]) -> bool:
        for handler in endpoint.event_handlers:
            with suppress(ValueError):  # the program has removed it
                self.remove_waitable(handler)
        return True


def destroy_owned(entity: Any, owned: list[Any]) -> bool:
    """Destroy an entity and remove it from its node's list `owned`; return False if the list lacks it."""
    try:
        owned.remove(entity)  # no look before: without a GIL, `in` misses members while others are removed
    except ValueError:
        return False
    entity.destroy()
    return True


# Python's errors show a function's qualified name, and users know these functions as methods of Node.
for _function in (
    TopicEndpoints.create_publisher,
    TopicEndpoints.create_subscription,
    TopicEndpoints.destroy_publisher,
    TopicEndpoints.destroy_subscription,
):
    _function.__qualname__ = f'Node.{_function.__name__}'
