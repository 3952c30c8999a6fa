"""The common base of Node and AsyncNode: names, built-in services and entities."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NoReturn

from goalwire.entities.builtin_services import start_builtin_services
from goalwire.entities.node import NodeCore
from goalwire.entities.node_graph import NodeGraph
from goalwire.entities.parameters.events import PARAMETER_EVENT, PARAMETER_EVENTS_TOPIC, ParameterEvents
from goalwire.entities.standard_types import standard_message
from goalwire.entities.type_support import ServiceSupport
from goalwire.errors import InvalidHandle, NameValidationException, RCLError, TopicExpansionError
from goalwire.execution.wait_sets.waitable import SelfDriven, Waitable
from goalwire.rules.qos import PARAMETER_EVENTS, PARAMETERS, QoS
from goalwire.transport.contract import EndpointKind
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from rclpy.client import Client
from rclpy.clock import ROSClock
from rclpy.constants import S_TO_NS
from rclpy.context import Context
from rclpy.exceptions import NotInitializedException
from rclpy.guard_condition import GuardCondition
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.logging import get_logger
from rclpy.publisher import Publisher
from rclpy.qos import (
    QoSProfile,
    qos_profile_parameter_events,
    qos_profile_parameters,
    qos_profile_rosout_default,
    qos_profile_services_default,
)
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.time_source import ClockedNode, ListedClockSubscription, TimeSource
from rclpy.timer import Rate, Timer
from rclpy.type_description_service import TypeDescriptionService
from rclpy.utilities import get_default_context

if TYPE_CHECKING:
    from rclpy.parameter import Parameter
    from rclpy.topic_endpoint_info import TopicEndpointInfo


def builtin_profile(qos: QoS) -> QoSProfile:
    """Return the QoS profile of one of the services that every node has."""
    return qos_profile_parameters if qos is PARAMETERS else qos_profile_services_default


class BaseNode(NodeGraph, ClockedNode):
    """A node of the ROS 2 graph: the common base of Node and AsyncNode."""

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: Sequence[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        rosout_qos_profile: QoSProfile | int = qos_profile_rosout_default,
        start_parameter_services: bool = True,
        parameter_overrides: list[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
        enable_logger_service: bool = False,
    ) -> None:
        """Construct the node; raises NotInitializedException before init(), and rclpy's name exceptions."""
        self._context = get_default_context() if context is None else context
        if not self._context.ok():
            if self._context.shutdown_signal.is_by_signal:
                raise self._context.shutdown_signal.end_error('cannot create node')
            raise NotInitializedException('cannot create node')
        self._ros_core = NodeCore(
            self._context, node_name, namespace, cli_args=cli_args, use_global_arguments=use_global_arguments
        )
        self.handle.make_service = self._ros_make_service
        self._ros_prepare()
        self._publishers: list[Publisher[Any]] = []
        self._subscriptions: list[Subscription[Any]] = []
        self._clients: list[Client[Any, Any]] = []
        self._services: list[Service[Any, Any]] = []
        self._timers: list[Timer] = []
        self._guards: list[GuardCondition] = []
        self._ros_waitables: list[Waitable[Any]] = []
        self._ros_rates: dict[Rate, Timer] = {}
        self._default_callback_group: CallbackGroup = MutuallyExclusiveCallbackGroup()
        self._default_callback_group.is_default = True
        self._clock = self.handle.clock = self._ros_make_clock()
        self._logger = get_logger(self.handle.logger_name)
        try:
            if enable_rosout and self._context.arguments.rosout_logs:
                self._context.rosout.join(self.handle, QoSProfile.of(rosout_qos_profile).to_core())
            self._ros_init_parameters(parameter_overrides or [], allow_undeclared=allow_undeclared_parameters)
            self._ros_parameter_events = ParameterEvents(self.handle, self._ros_parameter_event_publisher())
            if automatically_declare_parameters_from_overrides:
                self._ros_declare_overrides()
            self._ros_make_standing_parts(start_parameter_services, enable_logger_service)
        except BaseException:  # for example if an override is invalid
            self.handle.destroy()
            raise

    def _ros_make_standing_parts(self, parameter_services: bool, logger_services: bool) -> None:
        """Make the entities that every node has.

        The parameters must be declared already, since some of them decide which entities are made.
        """
        self._time_source = TimeSource(node=self)
        self._time_source.attach_clock(self._clock)
        self._type_description_service = start_builtin_services(
            self, TypeDescriptionService, parameters=parameter_services, loggers=logger_services
        )

    # -- identity ------------------------------------------------------------------------------------------

    if not TYPE_CHECKING:  # `attrgetter` is fast, and each spin reads `handle` twice
        handle = property(
            attrgetter('_ros_core'), doc='The implementation of the node: there is no C handle.'
        )

        def __getattr__(self, name: str) -> Any:
            """Raise AttributeError.

            If Node's own attributes are missing, the text says that __init__() was not called.
            """
            kind = type(self).__name__
            if name == '_parameters' and '_ros_parameters' in self.__dict__:
                return self._ros_parameters  # programs read rclpy's private name `_parameters`
            text = f'{kind!r} object has no attribute {name!r}'
            if '_ros_core' not in self.__dict__ and (name[0] == '_' or hasattr(BaseNode, name)):
                text = f"{kind} is not a node yet: {kind}.__init__() must call super().__init__('name') first"
            raise AttributeError(text, name=name, obj=self)

    @property
    def context(self) -> Context:
        """The context that the node belongs to."""
        return self._context

    @property
    def default_callback_group(self) -> CallbackGroup:
        """The mutually exclusive group of callbacks without a group of their own."""
        return self._default_callback_group

    def get_name(self) -> str:
        """Return the name without its namespace; raises InvalidHandle once destroyed."""
        self._ros_check_alive()
        return self.handle.name.name

    def get_namespace(self) -> str:
        """Return the namespace, '/' or '/a/b'; raises InvalidHandle once destroyed."""
        self._ros_check_alive()
        return self.handle.name.namespace

    def get_fully_qualified_name(self) -> str:
        """Return the name with its namespace: '/a/b/name'; raises InvalidHandle once destroyed."""
        self._ros_check_alive()
        return self.handle.name.qualified

    def get_clock(self) -> ROSClock:
        """Return the node's clock (ROS time)."""
        return self._clock

    def get_logger(self) -> RcutilsLogger:
        """Return the node's logger, which has a name such as 'a.b.name'."""
        return self._logger

    def _ros_prepare(self) -> None:
        """Prepare the node for its entities, before the first entity is made."""

    def _ros_make_clock(self) -> ROSClock:
        """Make the node's clock."""
        return self.handle.clock

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the fully-qualified name of a topic, remapped unless `only_expand`; raises RCLError."""
        self._ros_check_alive()
        with _failure_to_resolve():
            return self.handle.resolve(topic, only_expand=only_expand)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return the fully-qualified name of a service, remapped unless `only_expand`; raises RCLError."""
        self._ros_check_alive()
        with _failure_to_resolve():
            return self.handle.resolve(service, is_service=True, only_expand=only_expand)

    def _ros_parameter_event_publisher(self) -> Publisher[Any]:
        publisher: Publisher[Any] = Publisher(
            self.handle, standard_message(PARAMETER_EVENT), PARAMETER_EVENTS_TOPIC, PARAMETER_EVENTS
        )
        publisher.qos_profile = qos_profile_parameter_events
        self._publishers.append(publisher)
        return publisher

    def _ros_offer(
        self,
        support: ServiceSupport,
        name: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile,
    ) -> Service[Any, Any]:
        """Make a service whose request and response classes are made at their first use."""
        raise NotImplementedError

    def _ros_make_service(
        self,
        support: ServiceSupport,
        name: str,
        callback: Callable[..., object],
        qos: QoS,
        group: CallbackGroup | None = None,
    ) -> Service[Any, Any]:
        """Make one of the services that every node has."""
        return self._ros_offer(support, name, callback, builtin_profile(qos))

    def _ros_check_alive(self) -> None:
        if self.handle.destroyed:
            raise InvalidHandle

    def __repr__(self) -> str:
        cls = type(self)
        return f'<{cls.__module__}.{cls.__qualname__} object at {id(self):#x}: {self.handle.name.qualified}>'

    # -- entities ------------------------------------------------------------------------------------------

    @property
    def publishers(self) -> Iterator[Publisher[Any]]:
        """The publishers made by this node."""
        yield from self._publishers

    @property
    def subscriptions(self) -> Iterator[Subscription[Any]]:
        """The subscriptions made by this node, including the subscription to /clock."""
        yield from self._subscriptions
        for owned in self.handle.owned():
            if isinstance(owned, ListedClockSubscription):
                yield owned

    @property
    def clients(self) -> Iterator[Client[Any, Any]]:
        """The service clients made by this node."""
        yield from self._clients

    @property
    def services(self) -> Iterator[Service[Any, Any]]:
        """The service servers made by this node."""
        yield from self._services

    @property
    def timers(self) -> Iterator[Timer]:
        """The timers made by this node."""
        yield from self._timers

    @property
    def guards(self) -> Iterator[GuardCondition]:
        """The guard conditions made by this node."""
        yield from self._guards

    @property
    def waitables(self) -> Iterator[Waitable[Any]]:
        """The action servers and clients, and other waitables, of this node."""
        yield from self._ros_waitables

    def add_waitable(self, waitable: Waitable[Any]) -> None:
        """Add a waitable, so that the node's executor runs it, too."""
        self._ros_waitables.append(waitable)
        if not isinstance(waitable, SelfDriven):
            from goalwire.execution.wait_sets.waitable import WaitablePoller

            self.handle.work_queue.add_poller(WaitablePoller(self.handle.work_queue, waitable))

    def remove_waitable(self, waitable: Waitable[Any]) -> None:
        """Forget a waitable; raises ValueError if the node does not have it."""
        self._ros_waitables.remove(waitable)
        self.handle.work_queue.remove_poller(waitable)

    def get_publishers_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return the publishers of a topic, with type and QoS; raises ValueError for a bad topic name."""
        return self._ros_endpoint_infos(EndpointKind.PUBLISHER, topic_name, no_mangle)

    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return the subscriptions of a topic, with type and QoS; raises ValueError for a bad topic name."""
        return self._ros_endpoint_infos(EndpointKind.SUBSCRIPTION, topic_name, no_mangle)

    def _ros_endpoint_infos(self, kind: EndpointKind, topic: str, no_mangle: bool) -> list[TopicEndpointInfo]:
        from rclpy.topic_endpoint_info import TopicEndpointInfo

        return [
            TopicEndpointInfo.from_entity(entity) for entity in self._ros_endpoints(kind, topic, no_mangle)
        ]

    def destroy_node(self) -> None:
        """Destroy the node's entities, then the node. Idempotent."""
        for waitable in reversed(list(self._ros_waitables)):
            if isinstance(waitable, SelfDriven):
                waitable.destroy()
            else:  # waitables that the program made
                self.remove_waitable(waitable)
        self.handle.destroy()
        for owned in (self._publishers, self._subscriptions, self._clients, self._services):
            owned.clear()
        self._timers.clear()
        self._guards.clear()
        self._ros_waitables.clear()


def timer_period_ns(timer_period_sec: float) -> int:
    """Return a period in ns; raises RCLError for one below 0, TypeError or ValueError for a non-number."""
    given: object = timer_period_sec
    if callable(given) and not hasattr(given, '__float__'):
        raise TypeError(
            'the period of a timer is a number of seconds and stands before the callback: '
            'create_timer(0.5, callback)'
        )
    period = int(float(timer_period_sec) * S_TO_NS)
    if period < 0:
        error = RCLError('failed to create timer: timer period must be non-negative')
        error.add_note(f'got {timer_period_sec}; give the period in seconds, such as 0.5')
        raise error
    return period


def reserve_properties(cls: type) -> None:
    """Make assignments to read-only properties of `cls` raise an error that explains the name conflict."""
    for name, value in vars(cls).copy().items():
        if isinstance(value, property) and value.fset is None:
            setattr(cls, name, value.setter(partial(_refuse_value, name=name)))


def _refuse_value(node: object, _value: object, name: str) -> NoReturn:
    refuse_assignment(node, name)


def refuse_assignment(node: object, name: str) -> NoReturn:
    """Raise AttributeError, because a program sets an attribute whose name is a property of every node."""
    kind = type(node).__name__
    raise AttributeError(
        f"'{name}' is a property of every Node, and cannot be set: give this attribute of {kind} "
        f"another name, such as 'self.my_{name}'",
        name=name,
        obj=node,
    )


reserve_properties(BaseNode)
BaseNode.__init__.__qualname__ = 'Node.__init__'  # shown in TypeErrors


@contextmanager
def _failure_to_resolve() -> Iterator[None]:
    try:
        yield
    except (NameValidationException, TopicExpansionError) as error:
        raise RCLError(f'failed to resolve name: {error.reason}') from None
