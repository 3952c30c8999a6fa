"""A process with a session of goalwire's own: it does without eclipse-zenoh, and may fork."""

from __future__ import annotations

import os
import signal
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.processes import Program

from goalwire.transport.contract import EndpointKind

from .conftest import OpenSide

DATA = Path(__file__).parents[2] / 'data' / 'zenoh'
needs_fork = pytest.mark.skipif(not hasattr(os, 'fork'), reason='this system has no fork')

BEGIN = """
    import os, signal, sys
    from goalwire.errors import TransportError
    from goalwire.transport.contract import NodeName, SessionOptions
    from goalwire.transport.zenoh import TRANSPORT

    def open_session():
        return TRANSPORT.open(SessionOptions(int(os.environ['ROS_DOMAIN_ID'])))

    def imported():
        return sys.modules.get('zenoh') is not None
"""
HOLD = """
    session = open_session()
    node = session.node(NodeName('holder'))
    print('holds', flush=True)
    sys.stdin.readline()
    session.close()
"""


def program(body: str, env: dict[str, str]) -> Program:
    return Program(textwrap.dedent(BEGIN) + textwrap.dedent(body), env=env)


@pytest.fixture
def ours(world: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    monkeypatch.setenv('GOALWIRE_ZENOH', 'native')
    world['GOALWIRE_ZENOH'] = 'native'
    return world


@pytest.fixture
def holder(ours: dict[str, str]) -> Iterator[Program]:
    """Another process, which holds the rendezvous."""
    with program(HOLD, ours) as running:
        running.expect('holds')
        yield running


JOIN = """
    session = open_session()
    node = session.node(NodeName('here'))
    print('here', imported(), flush=True)
    sys.stdin.readline()
    session.close()
"""


def test_who_finds_a_rendezvous_imports_no_eclipse(
    ours: dict[str, str], holder: Program, open_side: OpenSide
) -> None:
    with program(JOIN, ours) as here:
        assert here.expect('here (.*)')[1] == 'False'
        open_side('ours').graph.expect(EndpointKind.NODE, '/here')


def test_nor_does_who_reads_a_file_and_overrides(
    ours: dict[str, str], holder: Program, open_side: OpenSide, tmp_path: Path
) -> None:
    file = tmp_path / 'session.json5'
    text = (DATA / 'session.json5').read_text(encoding='utf-8')
    file.write_text(text.replace('7447', ours['GOALWIRE_ROUTER_PORT']), encoding='utf-8')
    settings = {
        'ZENOH_SESSION_CONFIG_URI': str(file),
        'ZENOH_CONFIG_OVERRIDE': 'scouting/delay=5;connect/retry/period_init_ms=50',
    }
    with program(JOIN, ours | settings) as here:
        assert here.expect('here (.*)')[1] == 'False'
        open_side('ours').graph.expect(EndpointKind.NODE, '/here')


def test_nor_does_who_takes_the_port_over(ours: dict[str, str], holder: Program, open_side: OpenSide) -> None:
    body = """
    from helpers.patience import wait_for
    from goalwire.transport.zenoh.rendezvous import RENDEZVOUS
    session = open_session()
    print('here', imported(), flush=True)
    wait_for(lambda: RENDEZVOUS.holds(int(os.environ['GOALWIRE_ROUTER_PORT'])))
    node = session.node(NodeName('here'))
    print('holds', imported(), flush=True)
    sys.stdin.readline()
    session.close()
    """
    tests = Path(__file__).parents[2]
    with program(body, ours | {'PYTHONPATH': str(tests)}) as here:
        assert here.expect('here (.*)')[1] == 'False'
        holder.kill()
        assert here.expect('holds (.*)')[1] == 'False'
        open_side('late').graph.expect(EndpointKind.NODE, '/here')


def test_who_finds_a_rendezvous_needs_no_eclipse(
    ours: dict[str, str], holder: Program, open_side: OpenSide
) -> None:
    body = "sys.modules['zenoh'] = None  # as where it is not installed\n" + textwrap.dedent(JOIN)
    with program(body, ours) as here:
        here.expect('here')
        open_side('ours').graph.expect(EndpointKind.NODE, '/here')


@pytest.mark.parametrize(
    ('settings', 'said'),
    [
        (
            {'ROUTER_FILE': '{mode: "router", routing: {router: {peers_failover_brokering: true}}}'},
            'the rendezvous .* asks for .*. That needs eclipse-zenoh, .* run pip install .goalwire.eclipse.',
        ),
        (
            {'GOALWIRE_ROUTER': 'off', 'ZENOH_CONFIG_OVERRIDE': 'transport/unicast/lowlatency=true'},
            'asks for transport/unicast/lowlatency=true. That needs eclipse-zenoh, .*pip install',
        ),
        (
            {'GOALWIRE_ROUTER': 'off', 'GOALWIRE_ZENOH': 'eclipse'},
            'GOALWIRE_ZENOH=eclipse needs eclipse-zenoh',
        ),
    ],
)
def test_what_needs_it_says_so_in_one_line(
    ours: dict[str, str], settings: dict[str, str], said: str, tmp_path: Path
) -> None:
    if 'ROUTER_FILE' in settings:
        file = tmp_path / 'router.json5'
        file.write_text(settings['ROUTER_FILE'], encoding='utf-8')
        settings = {'ZENOH_ROUTER_CONFIG_URI': str(file)}
    body = """
    sys.modules['zenoh'] = None
    try:
        open_session()
    except TransportError as error:
        print('said:', error, flush=True)
    """
    with program(body, ours | settings) as running:
        running.expect(f'said: .*{said}')
        running.succeed()


def test_what_ours_does_not_do_is_eclipses(ours: dict[str, str], holder: Program) -> None:
    with program(JOIN, ours | {'ZENOH_CONFIG_OVERRIDE': 'namespace="robot1"'}) as here:
        assert here.expect('here (.*)')[1] == 'True'


@needs_fork
@pytest.mark.parametrize('who', ['holder', 'guest'])
def test_a_forked_child_opens_a_session_and_meets_its_parent(
    ours: dict[str, str], open_side: OpenSide, who: str, request: pytest.FixtureRequest
) -> None:
    """Also where the parent holds the rendezvous, and so has eclipse-zenoh running."""
    if who == 'guest':
        request.getfixturevalue('holder')
    body = """
    session = open_session()
    node = session.node(NodeName('parent'))
    child_is_up, up = os.pipe()
    child = os.fork()
    if child == 0:
        mine = open_session()
        there = mine.node(NodeName('child'))
        os.write(up, b'x')
        signal.pause()
    os.read(child_is_up, 1)
    print('both are up', flush=True)
    sys.stdin.readline()
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    print('child has gone', flush=True)
    sys.stdin.readline()
    session.close()
    """
    # from Python 3.12 on, fork warns of threads
    with program(body, ours | {'PYTHONWARNINGS': 'ignore::DeprecationWarning'}) as running:
        running.expect('both are up')
        here = open_side('here')
        here.graph.expect(EndpointKind.NODE, '/parent')
        here.graph.expect(EndpointKind.NODE, '/child')
        running.write_line('')
        running.expect('child has gone')
        here.graph.expect(EndpointKind.NODE, '/child', number=0)
        here.graph.expect(EndpointKind.NODE, '/parent')
        running.write_line('')
        running.succeed()


@needs_fork
def test_a_parent_that_is_killed_is_missed_although_its_child_lives(
    ours: dict[str, str], holder: Program, open_side: OpenSide
) -> None:
    """A child has copies of its parent's sockets; the others would wait for the lease of a minute."""
    body = """
    session = open_session()
    node = session.node(NodeName('parent'))
    print('parent is up', flush=True)
    sys.stdin.readline()
    child_is_up, up = os.pipe()
    child = os.fork()
    if child == 0:
        os.setsid()  # else it would be killed along with its parent
        os.write(up, b'x')
        signal.pause()
    os.read(child_is_up, 1)
    print('both are up', child, flush=True)
    signal.pause()
    """
    with program(body, ours | {'PYTHONWARNINGS': 'ignore::DeprecationWarning'}) as running:
        running.expect('parent is up')
        here = open_side('here')
        here.graph.expect(EndpointKind.NODE, '/parent')
        running.write_line('fork')  # only what is linked by then is copied
        child = int(running.expect('both are up (.*)')[1])
        try:
            running.kill()
            here.graph.expect(EndpointKind.NODE, '/parent', number=0)
        finally:
            os.kill(child, signal.SIGKILL)
