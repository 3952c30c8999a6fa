"""Whole programs without AF_UNIX, fork, /proc and POSIX's signals, by like_windows/sitecustomize.py."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command_line import CommandLine
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.programs import Start, programs_in
from helpers.wires import DDS, require

LACKS = Path(__file__).with_name('like_windows')

pytestmark = pytest.mark.slow


@pytest.fixture(params=['rmw_zenoh_cpp', DDS])
def world(request: pytest.FixtureRequest) -> dict[str, str]:
    """An environment whose programs find themselves on such a system, on each wire."""
    require(request.param)
    return isolated_env(request.param) | {'PYTHONPATH': str(LACKS)}


@pytest.fixture
def start(world: dict[str, str]) -> Iterator[Start]:
    """A function that starts a program of tests/processes/programs on such a system."""
    with programs_in(world) as start:
        yield start


LACKING = """
import os, select, signal, socket, subprocess, sys

missing = [
    name
    for module, names in (
        (os, 'eventfd fork mkfifo register_at_fork sched_yield'),
        (select, 'epoll poll'),
        (socket, 'AF_UNIX SO_REUSEPORT'),
        (signal, 'SIGCHLD SIGHUP SIGKILL SIGURG pthread_kill pthread_sigmask'),
    )
    for name in names.split()
    if not hasattr(module, name)
]
for name in ('fcntl', 'resource', 'pwd'):
    try:
        __import__(name)
    except ImportError:
        missing.append(name)
try:
    open('/proc/self/stat').close()
except FileNotFoundError:
    missing.append('/proc')
a, b = socket.socketpair()
a.sendall(b'x')
assert b.recv(1) == b'x'
print(sys.platform, len(missing), 'are missing')
subprocess.run([sys.executable, '-c', 'import os; print("a child, too:", hasattr(os, "fork"))'], check=True)
"""


def test_the_emulation_takes_them_away_from_programs_and_their_children() -> None:
    env = isolated_env('rmw_zenoh_cpp') | {'PYTHONPATH': str(LACKS)}
    with Program(LACKING, env=env) as program:
        output = program.succeed()
    assert 'win32 19 are missing' in output
    assert 'a child, too: False' in output


def test_goals_are_reached_cancelled_and_refused(start: Start) -> None:
    start('fibonacci_server').expect('ready')
    output = start('fibonacci_client').succeed()
    assert 'succeeded [0, 1, 1, 2, 3, 5, 8] after 5 feedback messages' in output
    assert 'canceled with return code 0, 1 goal canceling' in output
    assert 'refused' in output


def test_the_command_line_calls_a_service_and_lists_names(start: Start, world: dict[str, str]) -> None:
    start('add_server').expect('ready')
    ros2 = CommandLine(world)
    assert 'sum=5' in ros2.ok('service', 'call', '/add', 'example_interfaces/srv/AddTwoInts', '{a: 2, b: 3}')
    assert ros2.ok('node', 'list').split() == ['/add_server']


def test_ctrl_c_ends_a_spin(start: Start) -> None:
    server = start('add_server')
    server.expect('ready')
    server.send_signal(signal.SIGINT)
    assert server.wait() == 0
    assert server.output.splitlines()[-1] == 'stopped'


ASYNCIO = """
import asyncio
import goalwire
from example_interfaces.srv import AddTwoInts

async def main():
    async with goalwire.Node('asks') as node:
        client = node.client(AddTwoInts, 'add')
        await client.wait_for_server(timeout=20)
        answer = await client.call(a=2, b=3, timeout=20)
        print(answer.sum)

asyncio.run(main())
"""


def test_the_asyncio_api_calls_a_service(start: Start, world: dict[str, str]) -> None:
    start('add_server').expect('ready')
    with Program(ASYNCIO, env=world) as program:
        assert program.succeed().splitlines() == ['5']
