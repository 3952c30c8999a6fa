"""A context: one domain's session, graph and arguments, from init() to shutdown().

Both APIs use it. The session opens with the first node, so that a program may fork after init().
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Sequence
from functools import partial
from types import MethodType, TracebackType
from typing import TYPE_CHECKING, Self
from weakref import WeakMethod

from goalwire import logging
from goalwire.concurrency.exits import Stage, at_exit
from goalwire.concurrency.forks import ForkGuard, leak, reset_in_children
from goalwire.entities.arguments import override_use, process_arguments
from goalwire.entities.deadlock_detector import DeadlockDetector
from goalwire.entities.endpoint import EndpointPlaces
from goalwire.entities.rosout import Rosout
from goalwire.entities.unspun_nodes import UnspunNodes, ends_early
from goalwire.errors import NotInitializedException, RCLError
from goalwire.execution.rclpy_handle import handle_of
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.signals import signal_handlers, uncaught
from goalwire.execution.time.timer_heap import TimerThread
from goalwire.execution.weak_methods import weakly
from goalwire.graph.graph import Graph
from goalwire.graph.name_conflicts import Mismatch
from goalwire.graph.scope import within
from goalwire.places import at
from goalwire.rules import domain
from goalwire.rules.arguments import Arguments
from goalwire.transport import registry
from goalwire.transport.contract import Session, SessionOptions
from goalwire.weak_members import WeakMembers

if TYPE_CHECKING:
    from goalwire.rules.names.robots import RobotView
    from goalwire.rules.parameters.unused import OverrideUse

ShutdownCallback = Callable[[], object]


class Context:
    """Holds everything that lives from init() to shutdown(). Ends once; not reusable."""

    def __init__(self) -> None:
        self.shutdown_signal = ShutdownSignal()
        self.arguments = Arguments()
        self._lock = threading.RLock()
        self._fork_guard = ForkGuard()
        self._domain_id: int | None = None
        self._has_spun = False
        """Whether a thread has begun to spin without end, so that the program has made its nodes."""
        self.view: RobotView | None = None
        """The robots of a fleet that this context's nodes see; None: all nodes. Set before the first node."""
        self._session: Session | None = None
        self._graph: Graph | None = None
        self._callbacks: list[Callable[[], ShutdownCallback | None]] = []
        self._shut_down = False
        self.override_use: OverrideUse | None = None
        """Which of the arguments' parameters the nodes declare; None if the arguments have none."""
        self._logs = False
        self.deadlock_detector = DeadlockDetector()
        """The request servers of this context's nodes, to find blocking calls that one of them would have
        to answer."""
        self.rosout = Rosout()
        self.endpoint_places = EndpointPlaces()
        self.call_timeout: float | None = None
        """The time limit in s for calls whose client and node give none; None: no limit, as in ROS 2."""
        self.deadlines = TimerThread(self.shutdown_signal, 'goalwire-deadlines')
        """Ends calls at their deadlines. Its entries must not block."""
        self.shutdown_signal.alarms = self.deadlines
        self.unspun = UnspunNodes()
        """The nodes that have callbacks. The log names those that nobody spins."""
        self._are_mistakes_told = False
        self.sends = TimerThread(self.shutdown_signal, 'goalwire-sends')
        """Sends requests that had to wait. Its entries may block on the wire."""
        reset_in_children(self)

    # -- from init to shutdown ----------------------------------------------------------------------------

    def init(
        self,
        args: Sequence[str] | None = None,
        *,
        initialize_logging: bool = True,
        domain_id: int | None = None,
    ) -> None:
        """Read the arguments (`sys.argv` if they are None) and the environment.

        Raises RuntimeError if called twice or with a negative domain, RCLError for bad arguments.
        """
        with self._lock:
            if self._domain_id is not None:
                raise RuntimeError('Context.init() must only be called once')
            if domain_id is not None and domain_id < 0:
                raise RuntimeError(f'Domain id ({domain_id}) should not be lower than zero.')
            self.arguments = process_arguments(sys.argv if args is None else args)
            self.override_use = override_use(self.arguments)
            if initialize_logging:
                _refuse_log_config_file(self.arguments)
            self._domain_id = domain_from_environment() if domain_id is None else domain_id
            self.call_timeout = call_timeout_from_environment()
        if initialize_logging:
            self._configure_logging()
        self.shutdown_signal.early_looks.append(weakly(self._look_early))
        self.shutdown_signal.spin_listeners.add(self)
        uncaught.install_excepthooks()
        signal_handlers.register(self.shutdown_signal)
        _contexts.add(self)

    def _configure_logging(self) -> None:
        logging.configure(
            self.arguments.log_levels,
            to_console=self.arguments.stdout_logs,
            to_file=self.arguments.external_lib_logs,
            file_prefix=self.arguments.log_file_name,
        )
        self._logs = True

    @property
    def initialized(self) -> bool:
        """True from init() on, also after the context's end."""
        return self._domain_id is not None

    @property
    def is_inherited(self) -> bool:
        """True in a child process that was forked after this context was made."""
        return self._fork_guard.is_forked

    def reset_in_child(self) -> None:
        """In a forked child, make a new lock: a thread of the parent may hold the old one."""
        self._lock = threading.RLock()

    @property
    def handle(self) -> Self:
        """The context's handle, as rclpy's programs use it."""
        return handle_of(self)

    def ok(self) -> bool:
        """True from init() until the context ends, for whatever reason."""
        return self._domain_id is not None and self.shutdown_signal.alive

    def shutdown(self) -> None:
        """End the context: wake every waiter, run the shutdown callbacks, close the session.

        Raises RuntimeError before init(), RCLError if a signal or an earlier call ended it already.
        """
        if self._domain_id is None:
            raise RuntimeError('Context must be initialized before it can be shutdown')
        ended_before = self.shutdown_signal.reason not in {None, _AT_EXIT}
        self._end()
        if ended_before:
            raise RCLError('failed to shutdown: rcl_shutdown already called on the given context')

    def try_shutdown(self) -> None:
        """End the context unless it has ended already."""
        if self._domain_id is not None:
            self._end()

    def end_at_exit(self) -> None:
        """Wake every waiter, since the interpreter ends. A forked child leaves its parent's waiters alone."""
        if self.is_inherited:
            return
        if self.ok():
            self._tell_mistakes()
            self.shutdown_signal.end(_AT_EXIT)
        elif self._has_spun and not self._are_mistakes_told:  # a signal has ended the context
            self._are_mistakes_told = True
            self._tell_misspelt_overrides()

    def on_spin(self) -> None:
        """Note that a thread begins to spin without end."""
        self._has_spun = True

    def _tell_mistakes(self) -> None:
        """Log the mistakes that only the end shows, once: unused parameters, nodes that were never spun."""
        first, self._are_mistakes_told = not self._are_mistakes_told, True
        if not first:
            return
        if self.override_use is not None and not ends_early():
            for complaint in self.override_use.describe_unused():
                logging.get_logger('rcl').warning(complaint)
        else:
            self._tell_misspelt_overrides()
        unanswered = self.unspun.unanswered()
        for node in self.unspun.never_spun():
            logging.get_logger(node.logger).warning(node.describe(beside_calls=bool(unanswered)))
        for complaint in unanswered:
            logging.get_logger('rclpy').warning(complaint)

    def _tell_misspelt_overrides(self) -> None:
        """Log unused parameters that look misspelt: launch files may give others to nodes without them."""
        may_grow = 'rclpy_components' in sys.modules  # further nodes may be loaded at any time
        use = None if may_grow or ends_early(has_spun=self._has_spun) else self.override_use
        for complaint in use.describe_misspelt() if use else ():
            logging.get_logger('rcl').warning(complaint)

    def _look_early(self) -> None:
        """Log mistakes that show while one node is spun without end, instead of waiting for that end."""
        self._tell_misspelt_overrides()
        for node in self.unspun.waiting(self.shutdown_signal.clock.now()):
            node.is_told = True
            logging.get_logger(node.logger).warning(node.describe(beside_others=True))

    def _end(self) -> None:
        with self._lock:
            first, self._shut_down = not self._shut_down, True
        if not first:
            return
        if self.is_inherited and self._session is not None:
            self._end_in_child()
            return
        self._tell_mistakes()
        try:
            self.shutdown_signal.end('shutdown')
            self._run_shutdown_callbacks()
        finally:
            signal_handlers.unregister(self.shutdown_signal)
            self.deadlines.close()
            self.sends.close()
            self.rosout.close()
            with self._lock:
                session, self._session = self._session, None
            try:
                if session is not None:
                    session.close()
            finally:
                if self._logs:
                    logging.release()

    def _end_in_child(self) -> None:
        """End the context in a forked child: the session, threads and waiters are the parent's."""
        self.shutdown_signal.end_in_child('shutdown')
        try:
            self._run_shutdown_callbacks()
        finally:
            self._let_go()

    def leave_to_parent(self) -> None:
        """End the context in a forked child that makes its own, and run no shutdown callbacks. Idempotent."""
        with self._lock:
            first, self._shut_down = not self._shut_down, True
        if first and self._domain_id is not None:
            self.shutdown_signal.end_in_child('it was left to the parent')
            self._let_go()

    def _let_go(self) -> None:
        signal_handlers.unregister(self.shutdown_signal)
        leak(self._session)
        self._session = None
        if self._logs:
            logging.release()

    def on_shutdown(self, callback: ShutdownCallback) -> None:
        """Call `callback` at the context's end, at once if it has ended. Methods are held weakly."""
        if not callable(callback):
            raise TypeError(f'callback should be a callable, got {type(callback)}')
        with self._lock:
            if not self._shut_down:
                reference = WeakMethod(callback) if isinstance(callback, MethodType) else (lambda: callback)
                self._callbacks.append(reference)
                return
        callback()

    def _run_shutdown_callbacks(self) -> None:
        while True:
            with self._lock:
                if not self._callbacks:
                    return
                callback = self._callbacks.pop(0)()
            if callback is not None:
                callback()

    def destroy(self) -> None:
        """Release everything; the same as try_shutdown()."""
        self.try_shutdown()

    def __enter__(self) -> Self:
        """Initialise the context, unless it is initialised."""
        if self._domain_id is None:
            self.init()
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.try_shutdown()

    # -- what nodes share ----------------------------------------------------------------------------------

    def get_domain_id(self) -> int:
        """Return the domain; raises RuntimeError before init()."""
        if self._domain_id is None:
            raise RuntimeError('Context must be initialized before it can have a domain id')
        return self._domain_id

    @property
    def session(self) -> Session:
        """The open session. Raises NotInitializedException before init() and RCLError after the end."""
        with self._lock:
            if self._session is None:
                self._open()
            assert self._session is not None
            return self._session

    @property
    def graph(self) -> Graph:
        """The discovered nodes and endpoints."""
        with self._lock:
            if self._graph is None:
                self._open()
            assert self._graph is not None
            return self._graph

    def _open(self) -> None:
        if self._domain_id is None:
            raise NotInitializedException('cannot create node')
        if not self.shutdown_signal.alive:
            if self.shutdown_signal.is_by_signal:
                raise self.shutdown_signal.end_error('cannot create node')
            raise RCLError(
                'the given context is not valid, either init() was not called or shutdown() was; '
                'to begin anew, call rclpy.try_shutdown() and rclpy.init()'
            )
        options = SessionOptions(self._domain_id, self.arguments.enclave or '/', view=self.view)
        session = registry.get().open(options)
        graph = Graph(
            session.id, compares_definitions=session.compares_definitions, enforces_qos=session.enforces_qos
        )
        graph.on_mismatch(partial(_report, session.id, self.endpoint_places))
        try:
            session.watch_graph(within(self.view, graph, session.id))
        except BaseException:
            session.close()
            raise
        self._session, self._graph = session, graph
        self.shutdown_signal.take_session(session)
        signal_handlers.handle_in_child()


_AT_EXIT = 'exit'
_contexts: WeakMembers[Context] = WeakMembers()


def open_contexts() -> set[Context]:
    """Return the contexts of this process that are initialised and not shut down."""
    return {context for context in _contexts.alive() if context.ok()}


def _end_at_exit() -> None:
    """End the open contexts, so that threads stop spinning before the sessions close."""
    for context in _contexts.alive():
        context.end_at_exit()


at_exit(Stage.CONTEXTS, _end_at_exit)


def _report(session: str, places: EndpointPlaces, mismatch: Mismatch) -> None:
    """Warn of a reason why two endpoints do not match, and name the program's lines that made those of
    `session`.
    """
    own = [side for side in (mismatch.first, mismatch.second) if side.session == session]
    lines = dict.fromkeys(places.find(side.kind, side.name) for side in own)
    logging.get_logger('goalwire').warning(f'{mismatch}{at(", ".join(filter(None, lines)))}')


def _refuse_log_config_file(arguments: Arguments) -> None:
    if arguments.log_config_file is not None and arguments.external_lib_logs:
        raise RCLError(
            f"failed to initialize logging: '{arguments.log_config_file}' cannot be used, the logging "
            "backend has no configuration files; leave '--log-config-file' out"
        )


def domain_from_environment() -> int:
    """Return the domain that ROS_DOMAIN_ID names, 0 if it is not set; raises RCLError."""
    try:
        return domain.domain_from_environment()
    except ValueError as error:
        raise RCLError(f'failed to initialize rcl: {error}') from None


def call_timeout_from_environment() -> float | None:
    """Return the time limit of calls in s that GOALWIRE_CALL_TIMEOUT sets, None if it is not set; raises
    RCLError.
    """
    text = os.environ.get('GOALWIRE_CALL_TIMEOUT', '').strip()
    if not text:
        return None
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not seconds > 0:
        raise RCLError(
            f"failed to initialize: GOALWIRE_CALL_TIMEOUT is '{text}', which is not a time; "
            "set it to a number of seconds above 0, or to 'inf'"
        )
    return seconds
