"""ros2 router: programs that offer no rendezvous themselves meet at it."""

from __future__ import annotations

import signal
import socket

import pytest
from helpers.command_line import Begin, CommandLine
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.programs import Start

SUBSCRIBER = """
    import asyncio
    import goalwire
    from std_msgs.msg import String

    async def main():
        async with goalwire.Node('subscriber') as node:
            big = node.subscription(String, 'big')
            print('ready', flush=True)
            number = 0
            async for _ in big:
                number += 1
                if number == 30:
                    print('that fills all queues', flush=True)

    asyncio.run(main())
"""
PUBLISHER = """
    import asyncio
    import goalwire
    from std_msgs.msg import String

    async def main():
        async with goalwire.Node('publisher') as node:
            big = node.publisher(String, 'big')
            message = String(data='x' * 1_000_000)
            while True:
                big.publish(message)
                await asyncio.sleep(0.02)

    asyncio.run(main())
"""


@pytest.fixture(scope='module')
def world() -> dict[str, str]:
    """An environment on Zenoh in which nobody offers a rendezvous."""
    return {**isolated_env('rmw_zenoh_cpp'), 'GOALWIRE_ROUTER': 'off'}


def test_programs_meet_at_it(world: dict[str, str], begin: Begin, start: Start) -> None:
    router = begin('router')
    router.expect('^router [0-9a-f]+ listens on port [0-9]+ of every address; Ctrl-C ends it$')
    start('lonely').expect('^ready$')
    ros2 = CommandLine(world)
    assert '/lonely' in ros2.ok('service', 'list').splitlines()
    router.send_signal(signal.SIGINT)
    assert router.wait() == 130


@pytest.mark.slow
def test_it_ends_though_a_session_has_stopped_reading(world: dict[str, str], begin: Begin) -> None:
    router = begin('router')
    router.expect('Ctrl-C ends it$')
    client = {**world, 'ZENOH_CONFIG_OVERRIDE': 'mode="client"'}
    with Program(SUBSCRIBER, env=client) as stopped, Program(SUBSCRIBER, env=client) as reading:
        stopped.expect('ready')
        reading.expect('ready')
        stopped.send_signal(signal.SIGSTOP)
        with Program(PUBLISHER, env=client):
            reading.expect('that fills all queues')
            router.send_signal(signal.SIGINT)
            assert router.wait() == 130
    assert 'the router could not close all its links: close operation timed out' in router.output


def test_a_port_that_is_held_is_told(world: dict[str, str]) -> None:
    with socket.create_server(('::', 0), family=socket.AF_INET6, dualstack_ipv6=True) as holder:
        port = str(holder.getsockname()[1])
        told = CommandLine(world).fails('router', '--port', port, code=10)
    assert f'port {port} is held by ' in told
    assert 'give another --port' in told


def test_a_wrong_address_is_told(world: dict[str, str]) -> None:
    ros2 = CommandLine(world)
    assert 'router' in ros2.fails('router', '--listen', 'nonsense', code=10)
    assert 'from 1 to 65535' in ros2.fails('router', '--port', '70000', code=2)
