"""Both executors in turn, with a context and a node."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.execution import SmallContext, SmallNode

from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor


@pytest.fixture
def context() -> Iterator[SmallContext]:
    context = SmallContext()
    yield context
    context.shutdown()


@pytest.fixture
def single(context: SmallContext) -> Iterator[SingleThreadedExecutor]:
    with SingleThreadedExecutor(context=context) as executor:
        yield executor


@pytest.fixture
def multi(context: SmallContext) -> Iterator[MultiThreadedExecutor]:
    with MultiThreadedExecutor(4, context=context) as executor:
        yield executor


@pytest.fixture(params=['single', 'multi'])
def executor(request: pytest.FixtureRequest) -> Executor:
    chosen: Executor = request.getfixturevalue(request.param)
    return chosen


@pytest.fixture
def node() -> SmallNode:
    return SmallNode()
