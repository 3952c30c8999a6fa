"""AsyncNodes of an isolated context."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

import pytest
from rclpy.context import Context
from rclpy.experimental import AsyncNode

MakeAsyncNode: TypeAlias = Callable[..., AsyncNode]


@pytest.fixture
def make_async(context: Context) -> Iterator[MakeAsyncNode]:
    """Make nodes of the context. Those that no block has destroyed are destroyed after the test."""
    nodes: list[AsyncNode] = []

    def make(name: str = 'node', **options: object) -> AsyncNode:
        nodes.append(AsyncNode(name, context=context, **options))  # type: ignore[arg-type]
        return nodes[-1]

    yield make
    for node in nodes:
        node.destroy_node()
