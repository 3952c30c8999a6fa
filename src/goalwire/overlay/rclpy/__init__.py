"""ROS 2's Python API (rclpy), implemented by goalwire: functions to init, make nodes, spin and shut down."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from goalwire.errors import NotInitializedException
from goalwire.execution.signals.signal_handlers import is_ipython
from goalwire.locks import ForkableLock
from goalwire.places import at, caller_place, is_in_constructor
from goalwire.tracebacks import hide_own_frames
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions, install_signal_handlers, uninstall_signal_handlers
from rclpy.utilities import get_default_context, get_rmw_implementation_identifier, ok, try_shutdown
from rclpy.utilities import shutdown as _shutdown

if TYPE_CHECKING:
    from rclpy import executors as executors
    from rclpy import parameter as parameter
    from rclpy import qos as qos
    from rclpy import task as task
    from rclpy import time as time
    from rclpy.executors import Executor
    from rclpy.node import Node
    from rclpy.parameter import Parameter
    from rclpy.task import Future
else:

    def __getattr__(name: str) -> object:
        """Import a module of rclpy at its first use, so that `import rclpy` stays fast.

        Programs that only write `import rclpy` also use rclpy.executors and other modules, since ROS 2's
        rclpy imports them all.
        """
        from importlib import import_module

        if name in {'Parameter', 'Future'}:
            return getattr(import_module('rclpy.parameter' if name == 'Parameter' else 'rclpy.task'), name)
        if not name.startswith('_'):
            try:
                return import_module(f'rclpy.{name}')
            except ModuleNotFoundError as error:
                if error.name != f'rclpy.{name}':
                    raise
        raise AttributeError(f"module 'rclpy' has no attribute '{name}'")


__all__ = [
    'Context',
    'Future',
    'InitContextManager',
    'Parameter',
    'create_node',
    'get_default_context',
    'get_global_executor',
    'get_rmw_implementation_identifier',
    'init',
    'ok',
    'shutdown',
    'spin',
    'spin_once',
    'spin_until_future_complete',
    'try_shutdown',
    'uninstall_signal_handlers',
]

hide_own_frames()  # so that errors before or in init(), too, show the program's own lines

_global_executor: Executor | None = None
_executor_lock = ForkableLock()
"""Held while the global executor is created."""


class InitContextManager:
    """The result of init(): the end of its `with` block shuts the context down (ROS 2 Kilted and newer)."""

    def __init__(self, context: Context, installed: bool) -> None:
        self.context = context
        self._installed = installed

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        default = self.context is get_default_context()
        try:
            # For the default context pass None: then the next init() gets a new default context.
            try_shutdown(context=None if default else self.context)
        finally:
            if self._installed:
                uninstall_signal_handlers()


def init(
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
) -> InitContextManager:
    """Open a context (None: the default context) with `args` (None: `sys.argv`).

    By default SIGINT and SIGTERM end the default context, but not in IPython and notebooks, where an
    interrupt ends a cell. The signals do not end other contexts. `signal_handler_options` changes these
    rules. In a forked child this function opens a new default context and does not touch the parent's. Raises
    RuntimeError if the context was opened before, RCLError for bad arguments.
    """
    default = context is None
    if default and get_default_context().initialized:
        _leave_to_parent()
    chosen = get_default_context() if context is None else context
    if signal_handler_options is None:
        handled = default and not is_ipython()
        signal_handler_options = SignalHandlerOptions.ALL if handled else SignalHandlerOptions.NO
    if chosen.initialized:
        raise RuntimeError(
            f'Context.init() must only be called once; {_explain_second_init(chosen, default)}'
        )
    chosen.init(args, domain_id=domain_id)
    if signal_handler_options is not SignalHandlerOptions.NO:  # NO: keep the handlers of another context
        install_signal_handlers(signal_handler_options)
    return InitContextManager(chosen, signal_handler_options is not SignalHandlerOptions.NO)


def _leave_to_parent() -> None:
    """In a forked child, forget the parent's default context and executor."""
    global _global_executor  # noqa: PLW0603
    context = get_default_context()
    if context.is_inherited:
        context.leave_to_parent()
        get_default_context(shutting_down=True)
        _global_executor = None


def _explain_second_init(context: Context, default: bool) -> str:
    if not default:
        return 'make another Context: this one was open before'
    if context.ok():
        return 'rclpy.init() was called before: call rclpy.shutdown() first, or leave this call out'
    return 'a signal ended the context of the first call: call rclpy.try_shutdown() first'


def get_global_executor() -> Executor:
    """Return the executor that the spin functions use; raises NotInitializedException before init()."""
    global _global_executor  # noqa: PLW0603 - one for the whole program, as in rclpy
    if _global_executor is None and not get_default_context().initialized:
        raise NotInitializedException('cannot spin')
    from goalwire.execution.executors.single_threaded import SingleThreadedExecutor

    with _executor_lock:  # without the lock two threads could each create an executor
        executor = _global_executor
        if executor is None:
            executor = _global_executor = SingleThreadedExecutor()
            get_default_context().on_shutdown(_drop_global_executor)
    return executor


def _drop_global_executor() -> None:
    global _global_executor
    executor, _global_executor = _global_executor, None
    if executor is not None:
        executor.shutdown()


def shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:
    """Close a context (None: the default context). Raises RuntimeError or RCLError if it is not open."""
    default = context is None
    if default:
        _drop_global_executor()  # first, so that a spin() in another thread returns instead of raising
    try:
        _shutdown(context=context)
    finally:
        if uninstall_handlers or (uninstall_handlers is None and default):
            uninstall_signal_handlers()


def create_node(
    node_name: str,
    *,
    context: Context | None = None,
    cli_args: Sequence[str] | None = None,
    namespace: str | None = None,
    use_global_arguments: bool = True,
    enable_rosout: bool = True,
    start_parameter_services: bool = True,
    parameter_overrides: list[Parameter] | None = None,
    allow_undeclared_parameters: bool = False,
    automatically_declare_parameters_from_overrides: bool = False,
    enable_logger_service: bool = False,
) -> Node:
    """Create a node, as rclpy.node.Node(…) does."""
    from rclpy.node import Node

    return Node(
        node_name,
        context=context,
        cli_args=cli_args,
        namespace=namespace,
        use_global_arguments=use_global_arguments,
        enable_rosout=enable_rosout,
        start_parameter_services=start_parameter_services,
        parameter_overrides=parameter_overrides,
        allow_undeclared_parameters=allow_undeclared_parameters,
        automatically_declare_parameters_from_overrides=automatically_declare_parameters_from_overrides,
        enable_logger_service=enable_logger_service,
    )


def spin_once(node: Node, *, executor: Executor | None = None, timeout_sec: float | None = None) -> None:
    """Run at most one callback of `node`; wait up to `timeout_sec` for a callback (None: without limit)."""
    chosen = (_global_executor or get_global_executor()) if executor is None else executor
    added = chosen.add_node(node)
    try:
        chosen.spin_once(timeout_sec=timeout_sec)
    finally:
        if added:  # in a callback `added` is False, since the executor has the node already
            chosen.remove_node(node)


def spin(node: Node, executor: Executor | None = None) -> None:
    """Run the callbacks of `node` until the node's context ends.

    Raises ExternalShutdownException if a signal ended the context, KeyboardInterrupt on Ctrl-C.
    """
    chosen = (_global_executor or get_global_executor()) if executor is None else executor
    added = chosen.add_node(node)
    if not node.handle.has_callbacks and is_in_constructor(node, sys._getframe(1)):
        _tell_spin_in_constructor(node)
    try:
        chosen.spin_or_wait()
    finally:
        if added:
            chosen.remove_node(node)


def _tell_spin_in_constructor(node: Node) -> None:
    """Warn that this spin() runs no callbacks, since the lines that create them follow after it."""
    kind = type(node).__name__
    node.get_logger().warning(
        f'rclpy.spin(self) in {kind}.__init__() runs a node that has no callbacks yet, and the lines behind '
        f'it wait until the end: leave it out, and call rclpy.spin(node) when {kind}() has been made'
        f'{at(caller_place())}'
    )


def spin_until_future_complete(
    node: Node, future: Future[Any], executor: Executor | None = None, timeout_sec: float | None = None
) -> None:
    """Run the callbacks of `node` until `future` is done, the timeout has passed or the context ends."""
    if not hasattr(future, 'add_done_callback'):
        raise AttributeError(
            f'spin_until_future_complete(node, future) waits for a future, not for {future!r}: '
            'give the future that call_async() returns'
        )
    chosen = (_global_executor or get_global_executor()) if executor is None else executor
    added = chosen.add_node(node)
    try:
        chosen.spin_until_future_complete(future, timeout_sec)
    finally:
        if added:
            chosen.remove_node(node)
