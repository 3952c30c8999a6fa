"""python -m goalwire.apps.cli.commands.doctor.server NAME: serves `ros2 doctor` until its input ends."""

from __future__ import annotations

import asyncio
import sys

import goalwire


async def serve(name: str) -> None:
    """Serve std_srvs/srv/Trigger under a name."""
    from std_srvs.srv import Trigger

    async with goalwire.Node(name) as node:
        node.service(Trigger, name, lambda _request: Trigger.Response(success=True))
        await asyncio.to_thread(sys.stdin.read)


if __name__ == '__main__':
    asyncio.run(serve(sys.argv[1]))
