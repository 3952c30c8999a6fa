"""goalwire's own DDS session beside other vendors': all that ROS 2 has, with either side as the server."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeAlias

import pytest
from helpers import real_rclpy
from helpers.environments import Environment
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.wires import DDS

from goalwire.errors import TransportError
from goalwire.idl.search_path import SHIPPED
from goalwire.transport.dds import CHOICE, CYCLONE, NATIVE
from goalwire.transport.dds.cyclone.library import find_library

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

Side: TypeAlias = tuple[Path, dict[str, str]]
"""An interpreter, and what is set for it."""

PROGRAMS = Path(__file__).parent / 'programs'
SERVER, CLIENT = PROGRAMS / 'vendor_server.py', PROGRAMS / 'vendor_client.py'
FAST_DDS = 'rmw_fastrtps_cpp'
USES = ('graph', 'topics', 'latched', 'services', 'parameters', 'goals', 'qos', 'events')
LARGEST = 1_000_000
"""Bytes of the largest message; `python -m benchmarks.vendor_matrix` goes on to 16 MB."""


def _libddsc() -> tuple[Side, Side]:
    try:
        find_library()
    except TransportError as error:
        pytest.skip(str(error))
    here = Path(sys.executable)
    ours = {'RMW_IMPLEMENTATION': DDS, CHOICE: NATIVE}
    return (here, ours), (here, {'RMW_IMPLEMENTATION': DDS, CHOICE: CYCLONE})


def _real(install: Callable[..., Environment], wheels: tuple[str, ...]) -> tuple[Side, Side]:
    if not real_rclpy.EXISTS:
        pytest.skip(real_rclpy.WHY_NOT)
    python = install(*wheels).python
    definitions = {'AMENT_PREFIX_PATH': str(python.parents[1])}
    ours = {'RMW_IMPLEMENTATION': FAST_DDS, CHOICE: NATIVE, **definitions}
    return (Path(sys.executable), ours), (python, {'RMW_IMPLEMENTATION': FAST_DDS})


@pytest.fixture(
    params=[
        'libddsc',
        'rclpy of Jazzy on Fast DDS',
        pytest.param('rclpy of Kilted on Fast DDS', marks=pytest.mark.long),
    ]
)
def sides(request: pytest.FixtureRequest, install: Callable[..., Environment]) -> tuple[Side, Side]:
    """goalwire's own session, and another implementation."""
    if request.param == 'libddsc':
        return _libddsc()
    return _real(install, real_rclpy.WHEELS if 'Jazzy' in request.param else real_rclpy.KILTED)


def _check(serving: Program, calling: Program, uses: Iterable[str]) -> None:
    """See that a client finds all of these uses right."""
    found = {use: calling.expect(rf'^{use} (\d+) of (\d+)').groups() for use in uses}
    assert all(right == of for right, of in found.values()), found
    assert calling.wait() == 0
    serving.send_signal(signal.SIGINT)


def _check_all(server: Side, client: Side) -> None:
    shared = isolated_env(DDS)
    with Program(SERVER, str(LARGEST), env=shared | server[1], python=server[0]) as serving:
        serving.expect('ready')
        with Program(CLIENT, '20', '4', str(LARGEST), env=shared | client[1], python=client[0]) as calling:
            _check(serving, calling, USES)


def test_another_vendors_client_uses_our_server(sides: tuple[Side, Side]) -> None:
    ours, theirs = sides
    _check_all(ours, theirs)


def test_our_client_uses_another_vendors_server(sides: tuple[Side, Side]) -> None:
    ours, theirs = sides
    _check_all(theirs, ours)


# ---- RustDDS, by roswell: its nodes do not tell which endpoints are theirs, and other vendors read no reply
# ---- of its servers that has several fragments


@pytest.fixture
def rust(install: Callable[..., Environment]) -> Path:
    """The interpreter of an environment with roswell."""
    return install('roswell==0.1.0').python


OWN = {'RMW_IMPLEMENTATION': FAST_DDS, CHOICE: NATIVE}


def test_a_client_on_rustdds_uses_our_server(rust: Path) -> None:
    env = isolated_env(FAST_DDS) | OWN
    arguments = SHIPPED, '20', '4', '50000'
    with Program(SERVER, '50000', env=env) as serving:
        serving.expect('ready')
        with Program(PROGRAMS / 'roswell_client.py', *arguments, env=env, python=rust) as calling:
            _check(serving, calling, ('topics', 'latched', 'services', 'goals'))


def test_our_client_uses_a_server_on_rustdds(rust: Path) -> None:
    env = isolated_env(FAST_DDS) | OWN
    with Program(PROGRAMS / 'roswell_server.py', SHIPPED, '1000', env=env, python=rust) as serving:
        serving.expect('ready')
        with Program(CLIENT, '20', '4', '1000', 'no-graph', 'no-events', env=env) as calling:
            _check(serving, calling, ('topics', 'latched', 'services', 'parameters', 'goals', 'qos'))
