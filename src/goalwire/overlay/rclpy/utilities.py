"""rclpy.utilities: the default context, its state, and the names of RMW implementations."""

from __future__ import annotations

import sys
import threading
from collections.abc import Sequence

from goalwire.concurrency.forks import in_child
from goalwire.entities.arguments import node_arguments
from goalwire.execution.shutdown_signal import provide_default_context
from goalwire.transport import registry
from rclpy._reexports import reexport
from rclpy.constants import S_TO_NS
from rclpy.context import Context

g_default_context: Context | None = None
g_context_lock = threading.Lock()


def get_default_context(*, shutting_down: bool = False) -> Context:
    """Return the default context. After a shutdown a new context takes its place."""
    global g_default_context  # noqa: PLW0603 - rclpy's own name
    with g_context_lock:
        if g_default_context is None:
            g_default_context = Context()
        chosen = g_default_context
        if shutting_down:
            g_default_context = None
    return chosen


def remove_ros_args(args: Sequence[str] | None = None) -> list[str]:
    """Return `args` (None: `sys.argv`) without the part `--ros-args … --`; raises RCLInvalidROSArgsError."""
    return list(node_arguments(sys.argv if args is None else args).rest)


def ok(*, context: Context | None = None) -> bool:
    """True while a context (None: the default context) is open."""
    return (get_default_context() if context is None else context).ok()


def shutdown(*, context: Context | None = None) -> None:
    """Close a context (None: the default context); raises RuntimeError or RCLError if it is not open."""
    (get_default_context(shutting_down=True) if context is None else context).shutdown()


def try_shutdown(*, context: Context | None = None) -> None:
    """Close a context (None: the default context) if it is open."""
    (get_default_context(shutting_down=True) if context is None else context).try_shutdown()


def get_rmw_implementation_identifier() -> str:
    """Return the name of the wire in use, as RMW_IMPLEMENTATION spells it."""
    return registry.select_identifier()


def get_available_rmw_implementations() -> set[str]:
    """Return the names for RMW_IMPLEMENTATION of the wires that reach other processes.

    'goalwire_memory' is not in the list, although RMW_IMPLEMENTATION may name it: test suites start processes
    on each wire in the list, and wait until the processes discover each other.
    """
    return registry.available() - {registry.WITHIN_ONE_PROCESS}


def timeout_sec_to_nsec(timeout_sec: float | None) -> int:
    """Return a timeout in nanoseconds; -1 (no limit) for None and for negative times, as rclpy does."""
    if timeout_sec is None or timeout_sec < 0:
        return -1
    return int(float(timeout_sec) * S_TO_NS)


def _renew_lock() -> None:
    global g_context_lock  # noqa: PLW0603 - a thread that is not in a forked child may have held it
    g_context_lock = threading.Lock()


in_child(_renew_lock)
provide_default_context(get_default_context)

reexport(__name__)
