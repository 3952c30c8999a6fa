"""rclpy.node: the node, and everything it makes."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self, TypeVar, overload
from weakref import ReferenceType, ref

from goalwire.entities.type_support import ServiceSupport, ServiceType, service_support
from goalwire.errors import NodeNameNonExistentError
from goalwire.execution.callback_groups import check_group
from goalwire.execution.callbacks import advise_callback, describe_given
from rclpy._reexports import reexport
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from rclpy.client import Client
from rclpy.clock import Clock
from rclpy.guard_condition import GuardCondition
from rclpy.impl.base_node import BaseNode, builtin_profile, timer_period_ns
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, qos_profile_services_default
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Rate, Timer

if TYPE_CHECKING:
    from goalwire.entities.subscription import MessageInfo
    from goalwire.rules.qos import QoS
    from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
    from rclpy.executors import Executor
    from rclpy.qos_overriding_options import QoSOverridingOptions

HIDDEN_NODE_PREFIX = '_'

MsgT = TypeVar('MsgT')
RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')
EntityT = TypeVar('EntityT')

__all__ = ['HIDDEN_NODE_PREFIX', 'Node', 'NodeNameNonExistentError']


class Node(BaseNode):
    """A node whose callbacks an executor runs. Its block ends with its destruction, as in newer rclpy."""

    _ros_executor: ReferenceType[Executor] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.destroy_node()

    @property
    def executor(self) -> Executor | None:
        """The executor that runs this node's callbacks."""
        return self._ros_executor() if self._ros_executor is not None else None

    @executor.setter
    def executor(self, new_executor: Executor | None) -> None:
        current = self.executor
        if current is new_executor:
            return
        if current is not None:
            current.remove_node(self)
        if new_executor is None:
            self._ros_executor = None
        else:
            new_executor.add_node(self)
            self._ros_executor = ref(new_executor)

    def _ros_group(self, given: CallbackGroup | None) -> CallbackGroup:
        return self._default_callback_group if given is None else check_group(given)

    # -- what it makes -------------------------------------------------------------------------------------

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
        UnsupportedEventTypeError for an event that the wire cannot tell, InvalidQosOverridesError.
        """
        self.handle.check_open()
        profile = self._ros_overridden(QoSProfile.of(qos_profile), 'publisher', topic, qos_overriding_options)
        group = self._ros_group(callback_group)
        publisher: Publisher[MsgT] = publisher_class(self.handle, msg_type, topic, profile.to_core())
        publisher.qos_profile = profile
        self._ros_handle_events(publisher, event_callbacks, group)
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
    ) -> Subscription[MsgT]:
        """Create a subscription; `callback(message)` or `callback(message, info)`, plain or `async def`.

        With `raw` the callback gets serialized bytes. Raises as create_publisher does.
        """
        self.handle.check_open()
        profile = self._ros_overridden(
            QoSProfile.of(qos_profile), 'subscription', topic, qos_overriding_options
        )
        group = self._ros_group(callback_group)
        subscription = Subscription(self.handle, msg_type, topic, callback, profile.to_core(), group, raw=raw)
        subscription.qos_profile = profile
        subscription.callback_group = group
        group.add_entity(subscription)
        self._ros_handle_events(subscription, event_callbacks, group)
        self._subscriptions.append(subscription)
        return subscription

    def _ros_overridden(
        self, profile: QoSProfile, entity: str, topic: str, options: QoSOverridingOptions | None
    ) -> QoSProfile:
        """Return the profile with what the node's parameters say about this publisher or subscription."""
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
        """Attach the callbacks for the events of a new endpoint; if one is refused, destroy it."""
        from rclpy.event_handler import event_handlers

        try:
            endpoint.event_handlers = event_handlers(endpoint, callbacks, group)
        except BaseException:
            endpoint.destroy()
            raise
        self._ros_waitables.extend(endpoint.event_handlers)

    def create_client(
        self,
        srv_type: type[ServiceType[RequestT, ResponseT]],
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Client[RequestT, ResponseT]:
        """Create a service client. Raises InvalidServiceNameException, RuntimeError for a bad type."""
        self.handle.check_open()
        group = self._ros_group(callback_group)
        client: Client[RequestT, ResponseT] = Client(
            self.handle, service_support(srv_type), srv_name, qos_profile.to_core(), group
        )
        client.srv_type = srv_type
        client.qos_profile = qos_profile
        group.add_entity(client)
        self._clients.append(client)
        return client

    def create_service(
        self,
        srv_type: type[ServiceType[RequestT, ResponseT]],
        srv_name: str,
        callback: Callable[[RequestT, ResponseT], ResponseT | Awaitable[ResponseT]],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Service[RequestT, ResponseT]:
        """Create a service; `callback(request, response)` returns the response, plain or `async def`.

        Raises InvalidServiceNameException, RuntimeError for a bad type. A callback that does not take two
        arguments is told in the log, and raises TypeError when it is called.
        """
        self.handle.check_open()
        what = f"the callback of the service '{srv_name}'"
        advise_callback(callback, ('request', 'response'), what, self.get_logger())
        return self._ros_offer(service_support(srv_type), srv_name, callback, qos_profile, callback_group)

    def _ros_offer(
        self,
        support: ServiceSupport,
        name: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile,
        callback_group: CallbackGroup | None = None,
    ) -> Service[Any, Any]:
        group = self._ros_group(callback_group)
        service: Service[Any, Any] = Service(
            self.handle, support, name, callback, qos_profile.to_core(), group
        )
        service.qos_profile = qos_profile
        service.callback_group = group
        group.add_entity(service)
        self._services.append(service)
        return service

    def _ros_make_service(
        self,
        support: ServiceSupport,
        name: str,
        callback: Callable[..., object],
        qos: QoS,
        group: CallbackGroup | None = None,
    ) -> Service[Any, Any]:
        return self._ros_offer(support, name, callback, builtin_profile(qos), group)

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[..., object],
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Create a timer of a period in seconds, on the node's clock unless another is given.

        Raises RCLError below 0, TypeError or ValueError for what is not a number. A callback that is not a
        function is told in the log, and raises TypeError when it is called.
        """
        self.handle.check_open()
        period_ns = timer_period_ns(timer_period_sec)
        given: object = callback
        if not callable(given):
            problem = f'the callback of a timer must be a function: {describe_given(given)}'
            self.get_logger().warning(f'{problem}; the call will fail')
        return self._ros_timer(period_ns, callback, callback_group, clock, autostart=autostart)

    def _ros_timer(
        self,
        period_ns: int,
        callback: Callable[..., object] | None,
        callback_group: CallbackGroup | None,
        clock: Clock | None,
        *,
        autostart: bool = True,
    ) -> Timer:
        group = self._ros_group(callback_group)
        timer = Timer(
            callback,
            group,
            period_ns,
            self._clock if clock is None else clock,
            context=self._context,
            autostart=autostart,
            work_queue=self.handle.work_queue,
        )
        self._timers.append(timer)
        self.handle.own(timer)
        group.add_entity(timer)
        return timer

    def create_guard_condition(
        self, callback: Callable[[], object] | None, callback_group: CallbackGroup | None = None
    ) -> GuardCondition:
        """Create a guard condition, whose callback runs after each trigger()."""
        self.handle.check_open()
        group = self._ros_group(callback_group)
        guard = GuardCondition(callback, group, context=self._context, work_queue=self.handle.work_queue)
        self._guards.append(guard)
        self.handle.own(guard)
        group.add_entity(guard)
        return guard

    def create_rate(self, frequency: float, clock: Clock | None = None) -> Rate:
        """Create a rate of `frequency` Hz, to sleep by; raises ValueError unless it is above 0."""
        if frequency <= 0:
            raise ValueError('frequency must be > 0')
        self.handle.check_open()
        period_ns = timer_period_ns(1.0 / frequency)
        timer = self._ros_timer(period_ns, None, MutuallyExclusiveCallbackGroup(), clock)
        rate = Rate(timer, context=self._context)
        self._ros_rates[rate] = timer
        return rate

    # -- how it ends ---------------------------------------------------------------------------------------

    def destroy_publisher(self, publisher: Publisher[Any]) -> bool:
        """Destroy a publisher of this node; False if it is not (any more)."""
        return _destroy(publisher, self._publishers) and self._ros_forget_events(publisher)

    def destroy_subscription(self, subscription: Subscription[Any]) -> bool:
        """Destroy a subscription of this node; False if it is not (any more)."""
        listed = self._subscriptions if subscription in self._subscriptions else list(self.subscriptions)
        return _destroy(subscription, listed) and self._ros_forget_events(subscription)

    def _ros_forget_events(self, endpoint: Publisher[Any] | Subscription[Any]) -> bool:
        for handler in endpoint.event_handlers:
            if handler in self._ros_waitables:
                self.remove_waitable(handler)
        return True

    def destroy_client(self, client: Client[Any, Any]) -> bool:
        """Destroy a client of this node; False if it is not (any more)."""
        return _destroy(client, self._clients)

    def destroy_service(self, service: Service[Any, Any]) -> bool:
        """Destroy a service of this node; False if it is not (any more)."""
        return _destroy(service, self._services)

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer of this node; False if it is not (any more)."""
        return _destroy(timer, self._timers)

    def destroy_guard_condition(self, guard: GuardCondition) -> bool:
        """Destroy a guard condition of this node; False if it is not (any more)."""
        return _destroy(guard, self._guards)

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate of this node; False if it is not (any more)."""
        timer = self._ros_rates.pop(rate, None)
        if timer is None:
            return False
        rate.destroy()
        self.destroy_timer(timer)
        return True

    def destroy_node(self) -> None:
        """Destroy everything the node made, then the node. Idempotent."""
        self.executor = None
        for rate in list(self._ros_rates):
            self.destroy_rate(rate)
        super().destroy_node()


def _destroy(entity: Any, owned: list[Any]) -> bool:
    if entity not in owned:
        return False
    owned.remove(entity)
    entity.destroy()
    return True


reexport(__name__)
