"""rclpy.experimental.async_node: a node whose callbacks run in the program's own asyncio loop."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self, TypeVar, overload

from goalwire.entities.client import AwaitedCalls
from goalwire.entities.graph_waiting import await_graph
from goalwire.entities.type_support import ServiceClass, ServiceSupport, service_support
from goalwire.errors import DestroyedError, RCLError
from goalwire.execution.asyncio.clock import AsyncClock
from goalwire.execution.asyncio.executor import CallbackTasks, SharedLoop
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.clock_type import ClockType
from rclpy.event_handler import event_handlers
from rclpy.experimental.async_client import AsyncClient
from rclpy.experimental.async_publisher import AsyncPublisher
from rclpy.experimental.async_service import AsyncService
from rclpy.experimental.async_subscription import AsyncSubscription
from rclpy.experimental.async_timer import AsyncTimer
from rclpy.impl.base_node import BaseNode, timer_period_ns
from rclpy.qos import QoSProfile, qos_profile_services_default

if TYPE_CHECKING:
    from goalwire.entities.subscription import MessageInfo
    from goalwire.execution.ready_queue import CallbackSource
    from rclpy.subscription_content_filter_options import ContentFilterOptions

MsgT = TypeVar('MsgT')
RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


class AsyncNode(BaseNode):
    """A node that needs neither executor nor thread: use it by `async with`, or await `run()`.

    Callbacks, plain or `async def`, run in the asyncio loop that entered the node. The end of the block
    cancels running callbacks, waits until they have cleaned up, and destroys the node. An error in a callback
    acts like an error in a task of an asyncio.TaskGroup: the body of the block is cancelled, and the block
    raises an ExceptionGroup. Only the loop's thread may use the node.
    """

    _clock: AsyncClock

    def _ros_prepare(self) -> None:
        self._ros_runs = CallbackTasks()
        self._ros_host = SharedLoop(self.handle.work_queue, self.context.shutdown_signal, self._ros_runs)

    # -- life cycle ----------------------------------------------------------------------------------------

    async def __aenter__(self) -> Self:
        """Let the running loop run the callbacks.

        Raises RuntimeError if called twice or on a destroyed node.
        """
        self._ros_check_alive()
        if self._ros_host.running:
            raise RCLError(f"cannot enter the node '{self.handle.name.qualified}': it is running already")
        await self._ros_host.__aenter__()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            await self._ros_host.__aexit__(kind, error, trace)
        finally:
            self.destroy_node()

    async def run(self) -> None:
        """Run until the node is destroyed, the context is shut down or this task is cancelled.

        If the node has not been entered, this method enters it, and destroys it at the end.
        """
        if self._ros_host.running:
            await self._ros_host.wait()
            return
        async with self:
            await self._ros_host.wait()

    def destroy_node(self) -> None:
        """Destroy the node's entities, then the node; this makes `run` return. Idempotent."""
        try:
            super().destroy_node()
        finally:
            self._clock.close()
            self._ros_host.end()

    def get_clock(self) -> AsyncClock:
        """Return the node's clock (ROS time), for example for `await node.get_clock().sleep(seconds)`."""
        return self._clock

    async def wait_for_node(  # type: ignore[override]  # as rclpy has it
        self,
        fully_qualified_node_name: str,
        *,
        check_interval: float = 0.1,
    ) -> None:
        """Wait until the graph has a node of this name.

        Each change of the graph wakes this coroutine, so `check_interval` has no effect. Raises ShutDownError
        at shutdown.
        """
        self._ros_check_alive()
        namespace, _, name = fully_qualified_node_name.rpartition('/')
        namespace = '/' + namespace.strip('/')
        graph = self.handle.graph
        if not await await_graph(self.context, lambda: graph.node_exists(name, namespace)):
            raise self.context.shutdown_signal.end_error(
                f"the node '{fully_qualified_node_name}' did not appear"
            )

    # -- creation of entities ------------------------------------------------------------------------------

    def create_publisher(
        self, msg_type: type[MsgT], topic: str, qos_profile: QoSProfile | int
    ) -> AsyncPublisher[MsgT]:
        """Create a publisher; `qos_profile` is a profile or a history depth.

        As with Node, a warning is logged for subscriptions with incompatible QoS. Raises
        InvalidTopicNameException; TypeError or RuntimeError for a bad type or profile, or on a destroyed
        node.
        """
        self._ros_check_alive()
        profile = QoSProfile.of(qos_profile)
        publisher = AsyncPublisher(self.handle, msg_type, topic, profile.to_core())
        publisher.qos_profile = profile
        # The default callbacks for events log warnings.
        publisher.event_handlers = event_handlers(publisher, None, _group(False))
        publisher.on_destroy = self._ros_adopted(publisher, self._publishers)
        return publisher

    @overload
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[[MsgT], object],
        qos_profile: QoSProfile | int,
        *,
        raw: Literal[False] = False,
        concurrent: bool = False,
        content_filter_options: ContentFilterOptions | None = None,
    ) -> AsyncSubscription[MsgT]: ...
    @overload
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[[MsgT, MessageInfo], object],
        qos_profile: QoSProfile | int,
        *,
        raw: Literal[False] = False,
        concurrent: bool = False,
        content_filter_options: ContentFilterOptions | None = None,
    ) -> AsyncSubscription[MsgT]: ...
    @overload
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[[bytes], object],
        qos_profile: QoSProfile | int,
        *,
        raw: Literal[True],
        concurrent: bool = False,
        content_filter_options: ContentFilterOptions | None = None,
    ) -> AsyncSubscription[MsgT]: ...
    @overload
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile | int,
        *,
        raw: bool,
        concurrent: bool = False,
        content_filter_options: ContentFilterOptions | None = None,
    ) -> AsyncSubscription[MsgT]: ...
    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile | int,
        *,
        raw: bool = False,
        concurrent: bool = False,
        content_filter_options: ContentFilterOptions | None = None,
    ) -> AsyncSubscription[MsgT]:
        """Create a subscription; `callback(message)` or `callback(message, info)`, plain or `async def`.

        With `raw` the callback gets serialized bytes. Messages are handled one after the other or, with
        `concurrent`, at the same time. Content filters are not supported: if one is given, a warning is
        logged, and every message is delivered. Raises as create_publisher does.
        """
        self._ros_check_alive()
        profile = QoSProfile.of(qos_profile)
        group = _group(concurrent)
        subscription = AsyncSubscription(
            self.handle, msg_type, topic, callback, profile.to_core(), group, raw=raw
        )
        subscription.qos_profile = profile
        subscription.callback_group = group
        subscription.event_handlers = event_handlers(subscription, None, _group(False))
        subscription.on_destroy = self._ros_adopted(
            subscription, self._subscriptions, subscription.event_queue
        )
        if content_filter_options is not None:
            self._logger.warning(
                f"Topic '{subscription.full_name}': this wire cannot filter by content "
                f"('{content_filter_options.filter_expression}'): every message is delivered"
            )
        return subscription

    def create_service(
        self,
        srv_type: ServiceClass[RequestT, ResponseT],
        srv_name: str,
        callback: Callable[[RequestT, ResponseT], ResponseT | Awaitable[ResponseT]],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        concurrent: bool = False,
    ) -> AsyncService[RequestT, ResponseT]:
        """Create a service; `callback(request, response)` returns the response, plain or `async def`.

        Requests are answered one after the other or, with `concurrent`, at the same time. Raises
        InvalidServiceNameException, RuntimeError for a bad type or once destroyed.
        """
        self._ros_check_alive()
        return self._ros_offer(service_support(srv_type), srv_name, callback, qos_profile, concurrent)

    def _ros_offer(
        self,
        support: ServiceSupport,
        name: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile,
        concurrent: bool = False,
    ) -> AsyncService[Any, Any]:
        group = _group(concurrent)
        service: AsyncService[Any, Any] = AsyncService(
            self.handle, support, name, callback, qos_profile.to_core(), group
        )
        service.qos_profile = qos_profile
        service.callback_group = group
        service.on_destroy = self._ros_adopted(service, self._services, service.event_queue)
        return service

    def create_client(
        self,
        srv_type: ServiceClass[RequestT, ResponseT],
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
    ) -> AsyncClient[RequestT, ResponseT]:
        """Create a service client. Raises InvalidServiceNameException, RuntimeError for a bad type or once
        destroyed.
        """
        self._ros_check_alive()
        client: AsyncClient[RequestT, ResponseT] = AsyncClient(
            self.handle, service_support(srv_type), srv_name, qos_profile.to_core()
        )
        client.srv_type = srv_type
        client.qos_profile = qos_profile
        client.calls = AwaitedCalls(client)
        client.on_destroy = self._ros_adopted(client, self._clients)
        return client

    def create_timer(
        self, timer_period_sec: float, callback: Callable[..., object], autostart: bool = True
    ) -> AsyncTimer:
        """Create a timer on the node's clock, with a period in seconds. A late timer skips missed calls.

        Raises RCLError for a period below 0 or on a destroyed node, TypeError or ValueError if the period is
        not a number.
        """
        self._ros_check_alive()
        period_ns = timer_period_ns(timer_period_sec)
        timer = AsyncTimer(
            callback,
            _group(False),
            period_ns,
            self._clock,
            autostart=autostart,
            work_queue=self.handle.work_queue,
        )
        self.handle.own(timer)
        timer.on_destroy = self._ros_adopted(timer, self._timers, timer)
        return timer

    def _ros_adopted(
        self, entity: Any, owned: list[Any], work: CallbackSource | None = None
    ) -> Callable[[], None]:
        """Add an entity to a list of the node, and return the function to call when the entity is
        destroyed.
        """
        owned.append(entity)

        def discard() -> None:
            self.handle.disown(entity)
            with suppress(ValueError):
                owned.remove(entity)
            if work is not None:
                self._ros_runs.cancel(work)

        return discard

    def _ros_make_clock(self) -> AsyncClock:
        shutdown_signal = self.context.shutdown_signal
        return AsyncClock(
            clock_type=ClockType.ROS_TIME, source=shutdown_signal.clock, shutdown_signal=shutdown_signal
        )

    def _ros_check_alive(self) -> None:
        if self.handle.destroyed:
            raise DestroyedError(f"cannot use the node '{self.handle.name.qualified}': it was destroyed")


def _group(concurrent: bool) -> CallbackGroup:
    """Return a new callback group, one for each entity, so that entities never wait for each other."""
    return ReentrantCallbackGroup() if concurrent else MutuallyExclusiveCallbackGroup()
