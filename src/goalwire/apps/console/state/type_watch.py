"""Requests the definitions of unknown types in the graph from the nodes that use them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress

import goalwire
from goalwire.errors import UnknownInterfaceError
from goalwire.observe.described_types import fetch_type
from goalwire.observe.messages import interface_class

_AT_ONCE = 4
"""The most types that are requested at a time."""


class TypeWatch:
    """Requests each type once.

    If no node answers, the type is requested again when it reappears in the graph.
    """

    def __init__(self, node: goalwire.Node, on_answer: Callable[[], object]) -> None:
        """`on_answer` is called after each request, whether the type is known now or not."""
        self._node = node
        self._on_answer = on_answer
        self._turns = asyncio.Semaphore(_AT_ONCE)
        self._seen: set[str] = set()
        self._asking: dict[str, asyncio.Task[None]] = {}
        self.described: set[str] = set()
        """The types that are known because a node has described them."""

    def look(self) -> None:
        """Request the new types: call it when the graph has changed."""
        graph = self._node.graph
        shown = {
            type_name
            for kind, names in (
                ('msg', graph.topics()),
                ('srv', graph.services()),
                ('action', graph.actions()),
            )
            for _, types in names
            for type_name in types
            if f'/{kind}/' in type_name  # an action's type covers those of its parts
        }
        self._seen &= shown
        for name in sorted(shown - self._seen - self._asking.keys()):
            self._seen.add(name)
            self._asking[name] = asyncio.create_task(self._ask(name))

    async def _ask(self, name: str) -> None:
        try:
            async with self._turns:
                await asyncio.sleep(
                    0
                )  # Making a class takes some ms, so let the event loop serve the page in between.
                if _is_known(name):
                    return
                with suppress(goalwire.GoalwireError):  # A peer may have an invalid name.
                    if await fetch_type(self._node, name):
                        self.described.add(name)
        finally:
            del self._asking[name]
        self._on_answer()

    def is_asking(self, name: str) -> bool:
        """Return True while it is not known whether a node describes this type."""
        return name in self._asking

    def close(self) -> None:
        """Stop asking the nodes for definitions of types."""
        for task in list(self._asking.values()):
            task.cancel()


def _is_known(name: str) -> bool:
    try:
        interface_class(name)
    except UnknownInterfaceError:
        return False
    return True
