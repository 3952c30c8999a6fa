"""Waiting for the graph to look as wanted: woken by its changes, never polling."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from goalwire.entities.context import Context
from goalwire.execution.monotonic import deadline_after
from goalwire.logging import get_logger

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore


def wait_for_graph(context: Context, predicate: Callable[[], bool], timeout_sec: float | None) -> bool:
    """Block until `predicate()` holds (True), the time is over or the context ends (False).

    None and negative times wait without limit. Needs no executor.
    """
    if predicate():
        return True
    shutdown_signal = context.shutdown_signal
    clock = shutdown_signal.clock
    deadline = deadline_after(clock, timeout_sec)
    waiter = shutdown_signal.new_waiter()
    changes = context.graph.on_change(waiter.wake)
    try:
        while shutdown_signal.alive:
            if predicate():
                return True
            if not clock.wait(waiter, deadline):
                break
        return predicate()
    finally:
        changes.close()


def tell_near_misses(node: NodeCore, kind: str, name: str, told: str) -> str:
    """Warn of what in the graph is near to a service or action that was waited for in vain.

    Returns that; where it was `told` before, or nothing is near, nothing is said.
    """
    if not node.context.ok():
        return told
    from goalwire.graph.near_misses import near_misses

    hint = near_misses(node.context.graph, name, is_action=kind == 'action')
    if hint and hint != told:
        get_logger(node.logger_name).warning(f"{kind} '{name}': no server came; {hint}")
    return hint


async def graph_shows(context: Context, predicate: Callable[[], bool], deadline: int | None = None) -> bool:
    """Wait, in a coroutine under any asyncio loop, until `predicate()` holds (True).

    False where the context ends, or its steady clock shows `deadline`.
    """
    from goalwire.execution.asyncio.waiting import AsyncWaiter

    if predicate():
        return True
    shutdown_signal = context.shutdown_signal
    waiter = AsyncWaiter()
    changes = context.graph.on_change(waiter.wake)
    end = shutdown_signal.watch(waiter.wake)
    try:
        while shutdown_signal.alive:
            if predicate():
                return True
            left = None if deadline is None else deadline - shutdown_signal.clock.now()
            if left is not None and left <= 0:
                return False
            await waiter.wait(left)
        return False
    finally:
        end.close()
        changes.close()
