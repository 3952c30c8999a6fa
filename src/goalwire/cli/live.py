"""Running a command that takes part in the graph, and ending it with Ctrl-C."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING

from goalwire.cli.outcome import Outcome

if TYPE_CHECKING:
    import goalwire

NODE_NAME_PREFIX = '_ros2cli'
"""Nodes of the tools are hidden ones, as ROS 2's are."""


def live(main: Callable[[goalwire.Node], Awaitable[Outcome | None]], node_name: str | None = None) -> Outcome:
    """Run `main` with a node of the command's own, until it returns or Ctrl-C cancels it."""
    import goalwire

    async def run() -> Outcome | None:
        async with goalwire.Node(node_name or f'{NODE_NAME_PREFIX}_{os.getpid()}') as node:
            return await main(node)

    try:
        outcome = asyncio.run(run())
    except KeyboardInterrupt:
        return Outcome.INTERRUPTED
    sys.stdout.flush()
    return Outcome.OK if outcome is None else outcome
