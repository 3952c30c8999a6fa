"""A context in an isolated world on each transport, and executors that spin on their own threads."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.spinning import MakeNode, Spin, Spinner
from rclpy.context import Context
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node


@pytest.fixture
def context(isolated: dict[str, str]) -> Iterator[Context]:
    """An open context; its nodes end with it."""
    context = Context()
    context.init(args=[])
    yield context
    context.try_shutdown()


@pytest.fixture
def make_node(context: Context) -> Iterator[MakeNode]:
    """Make nodes of the context that are destroyed after the test."""
    nodes: list[Node] = []

    def make(name: str = 'node', **options: object) -> Node:
        nodes.append(Node(name, context=context, **options))  # type: ignore[arg-type]
        return nodes[-1]

    yield make
    for node in nodes:
        node.destroy_node()


@pytest.fixture(params=['single', 'multi'])
def executor(request: pytest.FixtureRequest, context: Context) -> Iterator[Executor]:
    """Each executor in turn."""
    with (
        SingleThreadedExecutor(context=context)
        if request.param == 'single'
        else MultiThreadedExecutor(4, context=context)
    ) as executor:
        yield executor


@pytest.fixture
def spin(context: Context) -> Iterator[Spin]:
    """Spin nodes on threads of their own: `spin(node, …)` single-threaded, `spin(node, threads=4)` else."""
    spinners: list[Spinner] = []

    def start(*nodes: Node, threads: int = 1) -> Spinner:
        chosen = (
            SingleThreadedExecutor(context=context)
            if threads == 1
            else MultiThreadedExecutor(threads, context=context)
        )
        spinners.append(Spinner(chosen, *nodes))
        return spinners[-1]

    yield start
    for spinner in spinners:
        spinner.close()
    for spinner in spinners:
        assert spinner.raised.items == [], 'came out of spin and was not looked at'
