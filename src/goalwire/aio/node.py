"""A node of the asyncio API: it lives as long as its `async with` block."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from threading import Lock
from typing import TYPE_CHECKING, Any, Literal, TypeVar, overload

from goalwire.aio.action.client import ActionClient
from goalwire.aio.action.server import ActionServer, Goal
from goalwire.aio.graph import GraphView
from goalwire.aio.parameters import Parameters, ParameterStore
from goalwire.aio.raw import RawPublisher, RawSubscription
from goalwire.aio.services import Client, LoggedService, Service
from goalwire.aio.timer import Timer
from goalwire.aio.topics import Publisher, Subscription
from goalwire.entities.actions.server_settings import make_goal_server
from goalwire.entities.builtin_services import start_builtin_services
from goalwire.entities.context import Context, domain_from_environment
from goalwire.entities.node import NodeCore
from goalwire.entities.time_source import NodeTimeSource
from goalwire.entities.type_description import TypeDescriptions
from goalwire.entities.type_support import ServiceClass, action_support, service_support
from goalwire.errors import ClosedError
from goalwire.execution.asyncio.clock import AsyncClock
from goalwire.execution.asyncio.executor import CallbackTasks, SharedLoop
from goalwire.execution.asyncio.waiting import in_thread
from goalwire.execution.time.steady_clock import timeout_ns
from goalwire.logging import RcutilsLogger, get_logger
from goalwire.rules.goals.policy import UNLIMITED
from goalwire.rules.names.robots import RobotView, view_of
from goalwire.rules.qos import SERVICES_DEFAULT, QoS
from goalwire.rules.time import ClockType

if TYPE_CHECKING:
    from pathlib import Path
    from types import TracebackType
    from typing import Self

    from goalwire.entities.actions.types import ActionClass
    from goalwire.entities.type_support import MessageSupport, ServiceSupport
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.rules.goals.journal import GoalJournal
    from goalwire.rules.goals.policy import GoalPolicy, OnClientLost
    from goalwire.rules.parameters import ParameterValue
    from goalwire.rules.retries import Retry
    from goalwire.rules.statistics import NodeStatistics
    from goalwire.transport.contract import Sample


MsgT = TypeVar('MsgT')
RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')
GoalT = TypeVar('GoalT')
ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')


class SharedContexts:
    """Opens a context for the first node of a domain and ends it after the last."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._users: dict[Context, int] = {}

    def take(self, domain: int | None, view: RobotView | None = None) -> Context:
        """Return the context of a domain, by default ROS_DOMAIN_ID's; call `close` after use. Any thread may
        call this.

        Nodes that look at the same robots share one.

        The context reads the program's ROS arguments, and installs no signal handlers. Raises RCLError for
        bad arguments.
        """
        number = domain_from_environment() if domain is None else domain
        with self._lock:
            for context in self._users:
                if context.ok() and context.get_domain_id() == number and context.view == view:
                    break
            else:
                context = Context()
                context.init(domain_id=number)
                context.view = view
            self._users[context] = self._users.get(context, 0) + 1
        return context

    @property
    def open(self) -> int:
        """How many contexts are open and not shut down."""
        return sum(context.ok() for context in list(self._users))

    def close(self, context: Context) -> None:
        """Give the context back for one node; the last one shuts it down, which may take time. Any thread may
        call this.
        """
        with self._lock:
            self._users[context] -= 1
            if self._users[context]:
                return
            del self._users[context]
        context.try_shutdown()


CONTEXTS = SharedContexts()
"""The contexts of this process."""


class Node:
    """A node: `async with goalwire.Node('name') as node:`, once. Only the loop's thread may use it.

    Leaving the block cancels the running handlers, waits until they have cleaned up, and closes everything
    that the node has made. An error in the block is raised unchanged. An error in a handler is logged, and
    its client gets an error.
    """

    def __init__(
        self,
        name: str,
        *,
        namespace: str | None = None,
        domain: int | None = None,
        robots: str | Sequence[str] = (),
        context: Context | None = None,
        arguments: Sequence[str] = (),
        program_arguments: bool = True,
        parameters: Mapping[str, ParameterValue] | None = None,
        call_timeout: float | None = None,
    ) -> None:
        """Prepare the node; entering its block opens it. `arguments` are this node's ROS arguments, in
        addition to the program's own.

        With `program_arguments=False` the node ignores the program's arguments, and has its own context.
        Nodes without a `context` share one for each `domain`, by default ROS_DOMAIN_ID's. With `robots`,
        names or patterns such as 'a*', the node sees these robots of a fleet and no others. `parameters`
        override the values in declarations. `call_timeout` is the timeout in s of calls without one, and of
        goals until they are accepted; by default GOALWIRE_CALL_TIMEOUT. Raises TypeError for a time that is
        not a number, ValueError for nan or a bad name of a robot.
        """
        if call_timeout is not None:
            timeout_ns(call_timeout, 'call_timeout')
        self._name = name
        self._namespace = namespace
        self._domain = domain
        self._view = view_of(robots) if robots else None
        self._given = context
        self._arguments = list(arguments)
        self._program_arguments = program_arguments
        self._overrides = dict(parameters or {})
        self._call_timeout = call_timeout
        self._runs = CallbackTasks()
        self._resources = ExitStack()
        self._core: NodeCore | None = None
        self._entered = False

    # -- its life ------------------------------------------------------------------------------------------

    async def __aenter__(self) -> Self:
        """Join the graph. Raises ClosedError if called twice, rclpy's name exceptions, TransportError."""
        if self._entered:
            raise ClosedError(f"the node '{self._name}' was entered before: make a new one")
        self._entered = True
        try:
            core = await in_thread(self._open)  # opening takes too long for the loop's thread
            self._host = SharedLoop(core.work_queue, core.context.shutdown_signal, self._runs)
            await self._host.__aenter__()
        except BaseException:
            await in_thread(self._resources.close)
            raise
        self._core = core
        return self

    def _open(self) -> NodeCore:
        context = self._given
        if context is None and not self._program_arguments:
            context = Context()
            context.init([], domain_id=self._domain)
            context.view = self._view
            self._resources.callback(context.try_shutdown)
        elif context is None:
            context = CONTEXTS.take(self._domain, self._view)
            self._resources.callback(CONTEXTS.close, context)
        core = NodeCore(context, self._name, self._namespace, cli_args=self._arguments)
        self._resources.callback(core.destroy)
        core.call_timeout = self._call_timeout
        shutdown_signal = context.shutdown_signal
        self._clock = AsyncClock(
            clock_type=ClockType.ROS_TIME, source=shutdown_signal.clock, shutdown_signal=shutdown_signal
        )
        core.clock = self._clock
        core.make_service = partial(_builtin_service, core)
        if context.arguments.rosout_logs:
            context.rosout.join(core)
        store = ParameterStore(core, self._overrides)
        NodeTimeSource(store)
        start_builtin_services(store, TypeDescriptions.start)
        self._parameters = Parameters(store)
        return core

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        core, self._core = self._open_core(), None
        try:
            await self._host.__aexit__(None, None, None)  # the handlers must not see the error of the block
        finally:
            self._clock.close()
            try:
                core.destroy()
            finally:
                await in_thread(self._resources.close)

    def _open_core(self) -> NodeCore:
        if self._core is None:
            raise ClosedError(
                f"the node '{self._name}' is open in its block alone: async with goalwire.Node(…) as node:"
            )
        return self._core

    # -- what it is ----------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """The node's fully-qualified name. This property and all methods of the node raise ClosedError
        outside its block.
        """
        return self._open_core().name.qualified

    @property
    def context(self) -> Context:
        """The node's context."""
        return self._open_core().context

    @property
    def logger(self) -> RcutilsLogger:
        """The node's logger, which publishes on /rosout, too."""
        return get_logger(self._open_core().logger_name)

    @property
    def clock(self) -> AsyncClock:
        """The node's clock: system time, or /clock with `use_sim_time`; `await node.clock.sleep(seconds)`."""
        self._open_core()
        return self._clock

    @property
    def parameters(self) -> Parameters:
        """The node's parameters."""
        self._open_core()
        return self._parameters

    @property
    def graph(self) -> GraphView:
        """The graph as this node sees it: nodes, endpoints, reasons why two do not match, and changes."""
        return GraphView(self._open_core())

    def statistics(self) -> NodeStatistics:
        """Return the statistics of everything that the node has, including its built-in services."""
        return self._open_core().statistics()

    # -- what it makes -------------------------------------------------------------------------------------

    def publisher(self, msg_type: type[MsgT], topic: str, *, qos: QoS | int = 10) -> Publisher[MsgT]:
        """Make a publisher; `qos` is a QoS or a history depth.

        Raises InvalidTopicNameException, and RuntimeError or AttributeError for a wrong message type.
        """
        return Publisher(self._open_core(), msg_type, topic, _qos(qos))

    @overload
    def subscription(
        self, msg_type: type[MsgT], topic: str, *, qos: QoS | int = 10, raw: Literal[False] = False
    ) -> Subscription[MsgT]: ...

    @overload
    def subscription(
        self, msg_type: type[Any] | MessageSupport, topic: str, *, qos: QoS | int = 10, raw: Literal[True]
    ) -> Subscription[bytes]: ...

    def subscription(
        self, msg_type: type[Any] | MessageSupport, topic: str, *, qos: QoS | int = 10, raw: bool = False
    ) -> Subscription[Any]:
        """Make a subscription: an async iterator of messages, or with `raw` of their serialized bytes.

        With `raw` the type may be a `find_message_support`, which needs no message class. Raises as
        `publisher` does.
        """
        return Subscription(self._open_core(), msg_type, topic, _qos(qos), raw=raw)

    def raw_publisher(
        self, topic: str, type_name: str, *, type_hash: str = '', qos: QoS | int = 10
    ) -> RawPublisher:
        """Make a publisher of serialized messages of 'pkg/msg/Name', whose definition may be unknown here.

        Without a `type_hash` the hash of the known definition is used. Raises InvalidTopicNameException.
        """
        return RawPublisher(self._open_core(), topic, type_name, type_hash, _qos(qos))

    def raw_subscription(
        self,
        topic: str,
        type_name: str,
        deliver: Callable[[Sample], None],
        *,
        type_hash: str = '',
        qos: QoS | int = 10,
    ) -> RawSubscription:
        """Call `deliver(sample)` for each serialized message of 'pkg/msg/Name', which may be unknown here.

        `deliver` runs on a thread of the wire, or on a publisher's thread in the same process. So it must be
        short and must not block. Without a `type_hash` the hash of the known definition is used. Raises
        InvalidTopicNameException.
        """
        return RawSubscription(self._open_core(), topic, type_name, type_hash, _qos(qos), deliver)

    def client(
        self,
        srv_type: ServiceClass[RequestT, ResponseT],
        name: str,
        *,
        qos: QoS = SERVICES_DEFAULT,
        timeout: float | None = None,
        retry: Retry | None = None,
    ) -> Client[RequestT, ResponseT]:
        """Make a service client. `timeout` is the default timeout of its calls, in s.

        With `retry` requests are sent again, so the service must be idempotent: see Retry. Raises
        InvalidServiceNameException, and RuntimeError or AttributeError for a wrong service type.
        """
        return Client(self._open_core(), service_support(srv_type), name, qos, timeout, retry)

    def service(
        self,
        srv_type: ServiceClass[RequestT, ResponseT],
        name: str,
        handler: Callable[[RequestT], ResponseT | Awaitable[ResponseT]],
        *,
        qos: QoS = SERVICES_DEFAULT,
        concurrent: bool = True,
    ) -> Service[RequestT, ResponseT]:
        """Serve requests with `handler(request)`, plain or `async def`, which returns the response.

        Requests are handled concurrently or, with `concurrent=False`, one after the other. Raises as
        `client` does.
        """
        support = service_support(srv_type)
        return Service(self._open_core(), support, name, handler, qos, self._runs, concurrent=concurrent)

    def timer(self, period: float) -> Timer:
        """Make a timer on the node's clock: an async iterator that gives the time every `period` s."""
        return Timer(self._open_core(), period)

    def action(
        self,
        action_type: ActionClass[GoalT, ResultT, FeedbackT],
        name: str,
        *,
        timeout: float | None = None,
    ) -> ActionClient[GoalT, ResultT, FeedbackT]:
        """Make an action client. `timeout` is the default timeout of its goals, in s.

        Raises InvalidTopicNameException, and RuntimeError or AttributeError for a wrong action type.
        """
        return ActionClient(self._open_core(), action_support(action_type), name, timeout)

    def action_server(
        self,
        action_type: ActionClass[GoalT, ResultT, FeedbackT],
        name: str,
        handler: Callable[[Goal[GoalT, FeedbackT]], Awaitable[ResultT]],
        *,
        accept: Callable[[GoalT], bool | Awaitable[bool]] | None = None,
        policy: GoalPolicy = UNLIMITED,
        on_client_lost: OnClientLost = 'keep',
        on_failure: Callable[[Goal[GoalT, FeedbackT], Exception], ResultT | None] | None = None,
        client_grace: float = 0.0,
        journal: str | Path | GoalJournal | None = None,
    ) -> ActionServer[GoalT, ResultT, FeedbackT]:
        """Serve goals with `async def handler(goal)`, which returns the result of a successful goal.

        A cancelled goal cancels its handler, as asyncio cancels tasks; raising GoalAborted, or any error,
        aborts the goal. `accept(goal.request)` returns True for goals to accept. `policy` says how many goals
        run at a time. `on_client_lost` says what happens to the goals of a client that has gone, unless
        another client asks for their results within `client_grace` s. `on_failure(goal, error)` is called
        after a handler has raised, and may return a result to send. With a `journal`, the path of a file, ids
        and results outlive the server: no id is executed twice, and `probe` tells of goals whose server died.
        Raises as `action` does; ValueError for an unknown `on_client_lost`; JournalError.
        """
        core, support = self._open_core(), action_support(action_type)
        reactor = make_goal_server(core, name, policy, on_client_lost, client_grace, journal)
        return ActionServer(core, support, name, handler, accept, on_failure, reactor)

    def __repr__(self) -> str:
        state = 'open' if self._core is not None else 'closed'
        return f'<goalwire.Node {self._name}, {state}>'


def _builtin_service(
    core: NodeCore,
    support: ServiceSupport,
    name: str,
    callback: Callable[..., object],
    qos: QoS,
    _group: CallbackGroup | None = None,
) -> LoggedService:
    return LoggedService(core, support, name, callback, qos, concurrent=False)


def _qos(given: QoS | int) -> QoS:
    return QoS(depth=given) if isinstance(given, int) else given
