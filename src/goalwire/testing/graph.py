"""The graph of a test: isolated, with scripted servers and recorders that the node under test talks to."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Self, TypeVar, overload

from goalwire.entities.context import Context, open_contexts
from goalwire.entities.graph_waiting import wait_for_graph
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import action_support, service_support
from goalwire.errors import LocalError
from goalwire.rules.qos import DEFAULT, HistoryPolicy, QoS
from goalwire.testing.action import Conduct, FakeAction
from goalwire.testing.calls import Outcome, call, send_goal
from goalwire.testing.log import PATIENCE
from goalwire.testing.service import FakeService
from goalwire.testing.topics import Publisher, Recorder
from goalwire.testing.world import World

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from types import TracebackType

    from goalwire.aio import Node
    from goalwire.entities.actions.types import ActionClass, FeedbackT, GoalT, ResultT
    from goalwire.entities.type_support import ServiceClass
    from goalwire.execution.executors.executor import Executor
    from goalwire.testing.answers import Answers
    from goalwire.testing.programs import Program
    from goalwire.testing.spinning import Spinning
    from goalwire.transport.endpoint import Closable
    from goalwire.transport.faults import Faults

MsgT = TypeVar('MsgT')
RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')
NodeT = TypeVar('NodeT')
EndsT = TypeVar('EndsT', bound='Closable')

EVERYTHING = QoS(history=HistoryPolicy.KEEP_ALL)


class Graph:
    """`with Graph() as graph:` nodes that the process opens in the block meet only each other.

    The end of the block ends all that was started through the graph. It raises an AssertionError for anything
    else that is still open, and for errors that callbacks of the nodes raised.
    """

    def __init__(self, transport: str = 'memory') -> None:
        """`transport` is 'memory', 'zenoh' or 'dds'."""
        self._transport = transport
        self._ends = ExitStack()
        self._problems: list[str] = []
        self._spinning: list[Spinning] = []
        self._programs: list[Program] = []
        self._context: Context | None = None
        self._faults: Faults | None = None
        self._numbers: dict[str, int] = {}
        self._opened_rclpy = False

    # -- begin and end ---------------------------------------------------------------------------------------

    def __enter__(self) -> Self:
        self._world = self._ends.enter_context(World(self._transport))
        self._before = open_contexts()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._ends:
            self._end_what_was_started()
            self._look_for_leaks()
            if self._context is not None:
                self._context.try_shutdown()
        if not self._problems:
            return
        text = '\n'.join(self._problems)
        if error is None:
            raise AssertionError(text)
        error.add_note(text)

    def _end_what_was_started(self) -> None:
        for spinning in self._spinning:
            if not spinning.close():
                self.blame(f"node '{spinning.name}': a callback did not end")
            for raised in spinning.raised:
                self.blame(f"node '{spinning.name}': a callback raised {raised!r}")
            spinning.node.destroy_node()
        rclpy = self._rclpy()
        self._end_programs(rclpy)
        if rclpy is not None:
            if not (self._opened_rclpy or self._programs):
                self.blame('rclpy was initialised and not shut down')
            rclpy.try_shutdown()
            rclpy.uninstall_signal_handlers()

    def _end_programs(self, rclpy: Any) -> None:
        for program in self._programs:
            program.stop()
        if rclpy is not None and self._programs:
            rclpy.get_default_context().shutdown_signal.end('the graph was closed')  # as a signal would
        for program in self._programs:
            if not program.close():
                self.blame(f"program '{program.name}' did not end with its context")
            elif program.unseen_error is not None:
                self.blame(f"program '{program.name}' raised {program.unseen_error!r}")

    def _rclpy(self) -> Any:
        """Return rclpy if it is imported and its default context is in this graph; else None."""
        rclpy = sys.modules.get('rclpy')
        if rclpy is None or rclpy.get_default_context() not in open_contexts() - self._before:
            return None
        return rclpy

    def _look_for_leaks(self) -> None:
        for context in open_contexts() - self._before - {self._context}:
            nodes = [entity for entity in context.graph.nodes() if entity.session == context.session.id]
            names = ', '.join(repr(entity.node.qualified) for entity in nodes)
            self.blame(f'left open: a context {f"with node {names}" if names else "without nodes"}')
            context.try_shutdown()

    def blame(self, problem: str) -> None:
        """Make the test fail with this sentence at the end of the block. Callable from any thread."""
        self._problems.append(problem)

    # -- the graph itself ------------------------------------------------------------------------------------

    @property
    def transport(self) -> str:
        """The transport: 'memory', 'zenoh' or 'dds'."""
        return self._transport

    @property
    def domain(self) -> int:
        """The ROS domain of the graph, which no other program uses."""
        return self._world.domain

    @property
    def environment(self) -> dict[str, str]:
        """The environment variables that bring a child process into this graph."""
        return dict(self._world.variables)

    @property
    def context(self) -> Context:
        """A context in this graph, for nodes of either API: `Node('name', context=graph.context)`."""
        if self._context is None:
            self._context = Context()
            self._context.init(args=[], domain_id=self._world.domain)
        return self._context

    @property
    def faults(self) -> Faults:
        """The faults of the graph's transport, at first none: `graph.faults.partition('talker', 'listener')`.

        Raises LocalError if `faults` is first read after a node was made.
        """
        if self._faults is None:
            if open_contexts() - self._before:
                raise LocalError('ask for the faults of a graph before its first node')
            from goalwire.transport.faults import Faults

            self._faults = self._ends.enter_context(Faults())
        return self._faults

    def nodes(self) -> list[str]:
        """Return the qualified names of the nodes in the graph, those of the test itself included."""
        return sorted(entity.node.qualified for entity in self.context.graph.nodes())

    def wait_for_node(self, name: str, *, timeout: float = PATIENCE) -> None:
        """Block until the graph has a node of that name; raises AssertionError after `timeout` s."""
        qualified = f'/{name.lstrip("/")}'
        if not wait_for_graph(self.context, lambda: qualified in self.nodes(), timeout):
            raise AssertionError(f"wanted node '{qualified}' within {timeout:g} s, got {self.nodes()}")

    # -- what is tested --------------------------------------------------------------------------------------

    @overload
    def start(
        self, node: Callable[[], NodeT], *, executor: Callable[[], Executor] | None = None
    ) -> NodeT: ...
    @overload
    def start(self, node: NodeT, *, executor: Callable[[], Executor] | None = None) -> NodeT: ...
    def start(self, node: Any, *, executor: Callable[[], Executor] | None = None) -> Any:
        """Make a node of rclpy (with its class, or any function) and let it spin until the end of the block.

        It has its own thread, with a SingleThreadedExecutor or the executor that `executor()` makes. If rclpy
        is not initialised yet, this method initialises it. An existing node may be given, too.
        """
        import rclpy

        from goalwire.testing.spinning import Spinning

        if not rclpy.ok():
            rclpy.init(args=[], signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
            self._opened_rclpy = True
        elif rclpy.get_default_context().get_domain_id() != self._world.domain:
            raise LocalError('rclpy was initialised outside this graph: leave that to the graph')
        made: Any = node() if callable(node) else node
        if not isinstance(made, rclpy.node.Node):
            raise TypeError(f'start() takes a node of rclpy, or what makes one, not {made!r}')
        core: NodeCore = made.handle
        if executor is None:
            executor = rclpy.executors.SingleThreadedExecutor
        self._spinning.append(Spinning(core.name.qualified, made, executor()))
        return made

    def run(self, main: Callable[..., Any], *arguments: str, node: str | None = None) -> Program:
        """Run a program's `main()`, plain or `async def`, in a thread, with these command line arguments.

        With `node` this method waits until the node of that name is there. The end of the block shuts down
        rclpy, which ends a program that spins; a program of asyncio is cancelled.
        """
        from goalwire.testing.programs import Program

        program = Program(main, arguments)
        self._programs.append(program)
        if node is not None:
            self.wait_for_node(node)
        return program

    def node(self, name: str, **options: Any) -> Node:
        """Make a node of the asyncio API in this graph: `async with graph.node('test') as node:`."""
        from goalwire.aio import Node

        return Node(name, context=self.context, **options)

    # -- what the node under test talks to -------------------------------------------------------------------

    def service(
        self,
        srv_type: ServiceClass[RequestT, ResponseT],
        name: str,
        answer: Answers[ResponseT] = None,
        *,
        node: str | None = None,
    ) -> FakeService[RequestT, ResponseT]:
        """Serve requests with `answer`: a response, or a function from a request to a response; NEVER;
        `after(seconds, answer)`; an exception, with which the handler fails; or a list of such answers, one
        for each call. None stands for a response with default values. The server runs in a node with the name
        `node`.
        """
        core = self._own_node(node or f'fake_{_last(name)}')
        return self._keep(FakeService(core, service_support(srv_type), name, answer, self.blame))

    def action(
        self,
        action_type: ActionClass[GoalT, ResultT, FeedbackT],
        name: str,
        *,
        feedback: Iterable[FeedbackT] = (),
        every: float = 0.1,
        result: ResultT | Callable[[GoalT], ResultT] | None = None,
        refuse: bool | Callable[[GoalT], bool] = False,
        abort: bool = False,
        never_ends: bool = False,
        cancel: bool = True,
        node: str | None = None,
    ) -> FakeAction[GoalT, ResultT, FeedbackT]:
        """Serve goals: publish a message of `feedback` each `every` seconds, then `result`; see
        testing.Conduct.
        """
        conduct = Conduct(feedback, every, result, refuse, abort, never_ends, cancel)
        core = self._own_node(node or f'fake_{_last(name)}')
        return self._keep(FakeAction(core, action_support(action_type), name, conduct))

    def record(
        self, msg_type: type[MsgT], topic: str, *, qos: QoS = EVERYTHING, node: str | None = None
    ) -> Recorder[MsgT]:
        """Record all messages on a topic from now on."""
        return self._keep(Recorder(self._own_node(node or f'record_{_last(topic)}'), msg_type, topic, qos))

    def publisher(
        self, msg_type: type[MsgT], topic: str, *, qos: QoS = DEFAULT, node: str | None = None
    ) -> Publisher[MsgT]:
        """Make a publisher."""
        return self._keep(Publisher(self._own_node(node or f'publish_{_last(topic)}'), msg_type, topic, qos))

    def call(
        self,
        srv_type: ServiceClass[RequestT, ResponseT],
        name: str,
        request: RequestT | None = None,
        *,
        timeout: float = PATIENCE,
        **fields: object,
    ) -> ResponseT:
        """Call a service under test, with a given request or one that is made of `fields`; see
        goalwire.Client.call.

        It blocks: in an `async def` test use a client of `graph.node(…)`.
        """
        return call(self.node(self._unique('caller')), srv_type, name, request, timeout, fields)

    def send_goal(
        self,
        action_type: ActionClass[GoalT, ResultT, FeedbackT],
        name: str,
        goal: GoalT | None = None,
        *,
        timeout: float = 60.0,
        **fields: object,
    ) -> Outcome[ResultT, FeedbackT]:
        """Send a goal to the action under test and wait for its end.

        Raises GoalRefused, GoalAborted, GoalCanceled, DeadlineError and similar errors; see goalwire.Run. The
        call blocks.
        """
        return send_goal(self.node(self._unique('goal_sender')), action_type, name, goal, timeout, fields)

    def _own_node(self, name: str) -> NodeCore:
        return NodeCore(self.context, self._unique(name))

    def _unique(self, name: str) -> str:
        number = self._numbers[name] = self._numbers.get(name, 0) + 1
        return name if number == 1 else f'{name}_{number}'

    def _keep(self, made: EndsT) -> EndsT:
        self._ends.callback(made.close)
        return made


def _last(name: str) -> str:
    return name.rpartition('/')[2].lstrip('~')
