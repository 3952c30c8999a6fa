"""Nodes of the asyncio API that outlive their loops: fifty of them hold no more descriptors than one."""

from __future__ import annotations

import asyncio
from pathlib import Path

from forked import expect
from std_msgs.msg import String

import goalwire
from goalwire.entities.context import Context

LOOPS = 50


def run_in_closed_loop(number: int) -> goalwire.Node:
    """Enter a node, hear something, and close the loop in the midst of the node's block."""
    loop = asyncio.new_event_loop()
    node = goalwire.Node(f'node_{number}', context=context)
    loop.run_until_complete(node.__aenter__())
    loop.run_until_complete(hear(node))
    loop.run_until_complete(loop.shutdown_default_executor())
    loop.close()
    return node


async def hear(node: goalwire.Node) -> None:
    """Receive what the node publishes itself. The subscription stays, and hears what others say later."""
    said = node.subscription(String, 'said')
    says = node.publisher(String, 'said')
    await says.wait_for_subscribers(1, timeout=20)
    says.publish(data=node.name)
    async with asyncio.timeout(20):
        async for message in said:
            if message.data == node.name:
                return


def count_descriptors() -> int:
    return len(list(Path('/proc/self/fd').iterdir()))


async def end_in_order() -> None:
    """A node that leaves its block still hears, whatever became of the others."""
    async with goalwire.Node('last', context=context) as node:
        await hear(node)


context = Context()
context.init()
nodes = [run_in_closed_loop(0)]
before = count_descriptors()
nodes += [run_in_closed_loop(number) for number in range(1, LOOPS)]
expect('descriptors', count_descriptors(), before)
asyncio.run(end_in_order())
expect('descriptors in the end', count_descriptors() < before, True)
context.try_shutdown()
print('good')
