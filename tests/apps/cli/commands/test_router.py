"""ros2 router: programs that offer no rendezvous themselves meet at it."""

from __future__ import annotations

import signal
import socket

import pytest
from helpers.command_line import Begin, CommandLine
from helpers.isolation import isolated_env
from helpers.programs import Start


@pytest.fixture(scope='module')
def world() -> dict[str, str]:
    """Zenoh, where nobody offers a rendezvous."""
    return {**isolated_env('rmw_zenoh_cpp'), 'GOALWIRE_ROUTER': 'off'}


def test_programs_meet_at_it(world: dict[str, str], begin: Begin, start: Start) -> None:
    router = begin('router')
    router.expect('^router [0-9a-f]+ listens on port [0-9]+ of every address; Ctrl-C ends it$')
    start('lonely').expect('^ready$')
    ros2 = CommandLine(world)
    assert '/lonely' in ros2.ok('service', 'list').splitlines()
    router.send_signal(signal.SIGINT)
    assert router.wait() == 130


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
