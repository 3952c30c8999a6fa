"""A node core on the memory transport, and an executor that spins it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.cores import Front
from helpers.isolation import isolated_env
from helpers.spinning import Spinner

from goalwire.entities.context import Context
from goalwire.entities.node import NodeCore
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Iterator[NodeCore]:
    """A node that nobody spins."""
    for name, value in isolated_env('goalwire_memory').items():
        monkeypatch.setenv(name, value)
    context = Context()
    context.init(args=[])
    yield NodeCore(context, 'node')
    context.shutdown()


@pytest.fixture
def spun(node: NodeCore) -> Iterator[NodeCore]:
    """The same node, spun on a thread of its own."""
    with SingleThreadedExecutor(context=node.context) as executor, Spinner(executor, Front(node)):
        yield node
