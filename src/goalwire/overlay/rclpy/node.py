"""rclpy.node: the node, which makes publishers, subscriptions, services, timers and more."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeVar
from weakref import ReferenceType, ref

from goalwire.entities.type_support import ServiceClass, ServiceSupport, service_support
from goalwire.errors import NodeNameNonExistentError
from goalwire.execution.callback_arguments import advise_callback, describe_given
from goalwire.places import at, caller_place
from rclpy._reexports import reexport
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from rclpy.client import Client
from rclpy.clock import Clock
from rclpy.guard_condition import GuardCondition
from rclpy.impl.base_node import builtin_profile, refuse_assignment, timer_period_ns
from rclpy.impl.topic_endpoints import TopicEndpoints, destroy_owned
from rclpy.qos import QoSProfile, qos_profile_services_default
from rclpy.service import Service
from rclpy.timer import Rate, Timer

if TYPE_CHECKING:
    from goalwire.rules.qos import QoS
    from rclpy.executors import Executor

HIDDEN_NODE_PREFIX = '_'

RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')

__all__ = ['HIDDEN_NODE_PREFIX', 'Node', 'NodeNameNonExistentError']


class Node(TopicEndpoints):
    """A node whose callbacks an executor runs.

    As in newer rclpy, the end of a `with` block destroys the node.
    """

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
        if new_executor is not None and not hasattr(new_executor, 'add_node'):
            refuse_assignment(self, 'executor')
        if current is not None:
            current.remove_node(self)
        if new_executor is None:
            self._ros_executor = None
        else:
            new_executor.add_node(self)
            self._ros_executor = ref(new_executor)

    # -- creation of entities ------------------------------------------------------------------------------

    def create_client(
        self,
        srv_type: ServiceClass[RequestT, ResponseT],
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
        srv_type: ServiceClass[RequestT, ResponseT],
        srv_name: str,
        callback: Callable[[RequestT, ResponseT], ResponseT | Awaitable[ResponseT]],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Service[RequestT, ResponseT]:
        """Create a service; `callback(request, response)` returns the response, plain or `async def`.

        Raises InvalidServiceNameException, RuntimeError for a bad type. A callback that does not take two
        arguments gives a warning, and raises TypeError when it is called.
        """
        self.handle.check_open()
        what = f"the callback of the service '{srv_name}'"
        advise_callback(callback, ('request', 'response'), what, self.get_logger())
        support = service_support(srv_type)
        service = self._ros_offer(support, srv_name, callback, qos_profile, callback_group)
        self.handle.note_callback('service')
        return service

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
        """Create a timer with a period in seconds, on the node's clock unless another clock is given.

        Raises RCLError for a period below 0, TypeError or ValueError for a period that is not a number. A
        callback that is not a function gives a warning, and raises TypeError when it is called.
        """
        self.handle.check_open()
        period_ns = timer_period_ns(timer_period_sec)
        given: object = callback
        if not callable(given):
            problem = f'the callback of a timer must be a function: {describe_given(given)}'
            self.get_logger().warning(f'{problem}; the call will fail{at(caller_place())}')
        timer = self._ros_timer(period_ns, callback, callback_group, clock, autostart=autostart)
        self.handle.note_callback('timer')
        return timer

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
        """Create a rate whose `sleep` keeps a loop at `frequency` Hz; raises ValueError for 0 or less."""
        if frequency <= 0:
            raise ValueError('frequency must be > 0')
        self.handle.check_open()
        period_ns = timer_period_ns(1.0 / frequency)
        timer = self._ros_timer(period_ns, None, MutuallyExclusiveCallbackGroup(), clock)
        rate = Rate(timer, context=self._context)
        self._ros_rates[rate] = timer
        return rate

    # -- destruction ---------------------------------------------------------------------------------------

    def destroy_client(self, client: Client[Any, Any]) -> bool:
        """Destroy a client of this node; False if the node does not have it."""
        return destroy_owned(client, self._clients)

    def destroy_service(self, service: Service[Any, Any]) -> bool:
        """Destroy a service of this node; False if the node does not have it."""
        return destroy_owned(service, self._services)

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer of this node; False if the node does not have it."""
        return destroy_owned(timer, self._timers)

    def destroy_guard_condition(self, guard: GuardCondition) -> bool:
        """Destroy a guard condition of this node; False if the node does not have it."""
        return destroy_owned(guard, self._guards)

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate of this node; False if the node does not have it."""
        timer = self._ros_rates.pop(rate, None)
        if timer is None:
            return False
        rate.destroy()
        self.destroy_timer(timer)
        return True

    def destroy_node(self) -> None:
        """Destroy the node's entities, then the node. Idempotent."""
        self.executor = None
        for rate in list(self._ros_rates):
            self.destroy_rate(rate)
        super().destroy_node()


reexport(__name__)
