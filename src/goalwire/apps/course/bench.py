"""Shared by the checks: the node that tests a program, and waits for the program's node and servers."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import goalwire
from goalwire.apps.course.student import Student, Wrong
from goalwire.logging.record import LoggingSeverity
from goalwire.testing.world import World

STARTS_WITHIN = 15.0
"""Seconds that a program has until its node appears, even on a busy machine."""
SERVES_WITHIN = 5.0
"""Seconds that a program has from the appearance of its node until its server appears."""


@asynccontextmanager
async def alone() -> AsyncIterator[goalwire.Node]:
    """Yield the check's node, in a graph with only the programs that are started in the block."""
    with World('zenoh'):
        async with goalwire.Node('checker') as node:
            # The node's servers fail on purpose. Their warnings would confuse a student.
            node.logger.set_level(LoggingSeverity.FATAL)
            yield node


@asynccontextmanager
async def beside(file: Path) -> AsyncIterator[tuple[goalwire.Node, Student]]:
    """Run the program in a graph of its own; yield the check's node and the program."""
    async with alone() as node, Student(file) as student:
        yield node, student


async def wait_for_node(node: goalwire.Node, student: Student) -> None:
    """Wait until the program has a node, or has ended; raises Wrong if no node appears."""
    try:
        async with asyncio.timeout(STARTS_WITHIN):
            await student.is_first(asyncio.create_task(_see_another(node)))
    except TimeoutError:
        raise Wrong(
            f'the program runs, but has no node after {STARTS_WITHIN:g} s',
            'main() makes the node; look at what holds it up before',
        ) from None


async def _see_another(node: goalwire.Node) -> None:
    """Wait until the graph has a node other than the check's own."""
    changes = node.graph.changes()
    while len(node.graph.nodes()) < 2:
        await anext(changes)


async def wait_for_server(
    node: goalwire.Node, student: Student, client: Any, kind: str, name: str, wanted: str
) -> None:
    """Wait for the program's server; raises Wrong, with the names of the servers that exist instead."""
    await wait_for_node(node, student)
    try:
        await student.during(client.wait_for_server(timeout=SERVES_WITHIN), f'serve the {kind} {name!r}')
    except goalwire.NoServerError:
        offered = _offered(node, kind)
    else:
        return
    if f'/{name}' in offered:
        raise Wrong(
            f'the {kind} {name!r} has the type {offered[f"/{name}"]}',
            f'the task wants {wanted}: look at the first arguments of your server',
        )
    others = ', '.join(f'{each} ({type_name})' for each, type_name in offered.items()) or 'none'
    server = 'ActionServer' if kind == 'action' else 'service'
    raise Wrong(
        f'the program serves no {kind} {name!r}; it serves: {others}',
        f'make the {server} in __init__ (step 1), and look at its name',
    )


def _offered(node: goalwire.Node, kind: str) -> dict[str, str]:
    """Return names and types of the program's servers, without those that every node has."""
    found = node.graph.served_actions() if kind == 'action' else node.graph.served()
    return {
        name: ', '.join(types)
        for name, types in found
        if '/_' not in name and not types[0].startswith(('rcl_interfaces/', 'type_description_interfaces/'))
    }
