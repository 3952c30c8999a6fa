"""Calls awaited one after the other in an asyncio program: goalwire's own API."""

from __future__ import annotations

import asyncio

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of
from benchmarks.lines.service_name import SERVICE
from benchmarks.lines.service_spin import answer

LINE = Line(
    'asyncio client, sequential calls',
    __name__,
    2000,
    ('p50', 'p99', 'cpu'),
    (
        Goal('p50', Of.TCP, 1.2, None),
        Goal('p50', Of.RAW, None, 1.1),
    ),
    floor='asyncio',
    peer=False,
    spins=False,
)


async def measure(count: int, partner: stage.Partner) -> Figures:
    from std_srvs.srv import SetBool

    import goalwire

    async with goalwire.Node('bench_client') as node:
        client = node.client(SetBool, SERVICE)
        await client.wait_for_server(timeout=spinning.PATIENCE_S)
        return await stage.awaited(lambda: client.call(data=True), count, partner)


def ask(count: int) -> Figures:
    with stage.Partner('benchmarks.lines.service_spin') as partner:
        return asyncio.run(measure(count, partner))


if __name__ == '__main__':
    stage.run(ask, answer)
