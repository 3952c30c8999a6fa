"""Both bridges on each wire, beside types that are not installed and simulated time; and encrypted."""

from __future__ import annotations

import ssl
import struct
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from helpers.away import STRANGER, knowing_away
from helpers.bridge import FoxgloveClient, WebSocket, start_bridge
from helpers.isolation import NETWORK, isolated_env
from helpers.processes import Program
from helpers.wires import DDS
from websockets.exceptions import InvalidMessage

PROGRAMS = Path(__file__).with_name('programs')


@pytest.fixture(scope='module', params=[NETWORK, DDS])
def world(request: pytest.FixtureRequest) -> dict[str, str]:
    return isolated_env(request.param)


@pytest.fixture(scope='module')
def stranger(world: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Program]:
    """A node whose types the bridges do not know."""
    env = knowing_away(world, tmp_path_factory.mktemp('away'))
    with Program(STRANGER, env=env) as program, Program(PROGRAMS / 'robot.py', env=world) as robot:
        program.expect('^ready$')
        robot.expect('ready')
        yield program


@pytest.fixture(scope='module')
def simulation(world: dict[str, str]) -> Iterator[Program]:
    with Program(PROGRAMS / 'simulation.py', env=world) as program:
        program.expect('ready')
        yield program


@pytest.fixture(scope='module')
def urls(world: dict[str, str], stranger: Program, simulation: Program) -> Iterator[dict[str, str]]:
    """The addresses of both bridges, by their protocols."""
    with ExitStack() as stack:
        yield {
            protocol: start_bridge(stack, world, protocol, '--use-sim-time').url
            for protocol in ('rosbridge', 'foxglove')
        }


# -- types that are not installed ----------------------------------------------------------------------------


def test_rosbridge_asks_the_node_for_the_type_of_a_topic(urls: dict[str, str]) -> None:
    with WebSocket(urls['rosbridge']) as client:
        client.send('subscribe', topic='/gauge', type='away_interfaces/msg/Gauge')
        message = client.expect('publish')['msg']
        assert (message['name'], message['needle'], message['scale']) == ('oil', {'angle': 0.5}, [0.0] * 3)


def test_foxglove_shows_the_schema_that_the_node_describes(urls: dict[str, str]) -> None:
    with FoxgloveClient(urls['foxglove']) as client:
        assert 'MSG: away_interfaces/Needle\nfloat64 angle' in client.channel('/gauge')['schema']
        client.subscribe('/gauge', 1)
        while (frame := client.receive_bytes())[0] != 1:
            pass
        assert b'oil' in frame


def test_a_service_and_an_action_of_unknown_types_are_served(
    world: dict[str, str], urls: dict[str, str]
) -> None:
    if world['RMW_IMPLEMENTATION'] == DDS:
        pytest.skip('DDS shows no hash of a service, and no node describes a type without its hash')
    with WebSocket(urls['rosbridge']) as client:
        assert client.call('/tune', wanted=1.5)['values'] == {'reached': 3.0}
        goal = {'action': '/sweep', 'action_type': 'away_interfaces/action/Sweep', 'args': {'sweeps': 3}}
        client.send('send_action_goal', id='g', feedback=True, **goal)
        assert client.expect('action_feedback')['values'] == {'part': 0.5}
        assert client.expect('action_result')['values'] == {'sweeps': 3}
    with FoxgloveClient(urls['foxglove']) as shown:
        assert 'away_interfaces/Sweep_Feedback feedback' in shown.channel('/sweep/_action/feedback')['schema']
        answer = shown.call('/tune', b'\0\1\0\0' + struct.pack('<d', 1.5))
        assert struct.unpack_from('<d', answer, 4) == (3.0,)


# -- simulated time ------------------------------------------------------------------------------------------


def _time_frames(client: FoxgloveClient) -> Iterator[int]:
    while True:
        frame = client.receive_bytes()
        if frame[0] == 2:
            yield struct.unpack_from('<Q', frame, 1)[0]


def test_foxglove_is_told_the_simulated_time(urls: dict[str, str]) -> None:
    with FoxgloveClient(urls['foxglove']) as first:
        first.channel('/clock')  # by then the bridge knows that there is a clock
    with FoxgloveClient(urls['foxglove']) as client:
        assert 'time' in client.greeting['capabilities']
        times = _time_frames(client)
        earlier, later = next(times), next(times)
        assert 1000 * 10**9 <= earlier < later < 10**15


def test_rosbridge_stamps_and_tells_the_simulated_time(urls: dict[str, str]) -> None:
    with WebSocket(urls['rosbridge']) as client:
        told = client.call('/rosapi/get_time')['values']['time']
        assert 1000 <= told['sec'] < 10**6
        client.send('subscribe', topic='/corner', type='std_msgs/Header')
        client.send('advertise', topic='/corner', type='std_msgs/Header')
        client.send('publish', topic='/corner', msg={'stamp': 'now', 'frame_id': 'map'})
        assert told['sec'] <= client.expect('publish')['msg']['stamp']['sec'] < 10**6


# -- topics, services and actions of known types, on this wire -----------------------------------------------


def test_messages_calls_and_goals_go_both_ways(urls: dict[str, str]) -> None:
    goal: dict[str, Any] = {'action': '/fibonacci', 'action_type': 'example_interfaces/action/Fibonacci'}
    with WebSocket(urls['rosbridge']) as client:
        client.send('subscribe', topic='/picture', type='sensor_msgs/Image')
        client.send('advertise', topic='/say', type='std_msgs/String')
        client.send('publish', topic='/say', msg={'data': 'hello'})
        assert client.expect('publish')['msg']['data'] == 'AH//'
        assert client.call('/add', a=2, b=3)['values'] == {'sum': 5}
        client.send('send_action_goal', id='g', args={'order': 4}, feedback=True, **goal)
        assert client.expect('action_feedback')['values'] == {'sequence': [0, 1, 1]}
        assert client.expect('action_result')['values'] == {'sequence': [0, 1, 1, 2, 3]}
        assert client.call('/rosapi/get_param', name='/robot:speed')['values'] == {'value': '0.5'}


# -- encrypted -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize('protocol', ['rosbridge', 'foxglove'])
def test_tls_is_spoken_and_nothing_else(world: dict[str, str], tmp_path: Path, protocol: str) -> None:
    if world['RMW_IMPLEMENTATION'] == DDS:
        pytest.skip('the wire does not matter to that')
    trustme = pytest.importorskip('trustme')
    authority = trustme.CA()
    certificate = authority.issue_cert('localhost')
    key, chain = tmp_path / 'key.pem', tmp_path / 'cert.pem'
    certificate.private_key_pem.write_to_path(str(key))
    certificate.cert_chain_pems[0].write_to_path(str(chain))
    trusting = ssl.create_default_context()
    authority.configure_trust(trusting)
    client = WebSocket if protocol == 'rosbridge' else FoxgloveClient
    with ExitStack() as stack:
        stack.enter_context(Program(PROGRAMS / 'robot.py', env=world)).expect('ready')
        url = start_bridge(stack, world, protocol, '--tls-cert', str(chain), '--tls-key', str(key)).url
        assert url.startswith('wss://localhost:')
        with client(url, ssl=trusting) as connected:
            assert connected.socket.protocol.state.name == 'OPEN'
        with pytest.raises(ssl.SSLCertVerificationError), client(url):
            pytest.fail('a stranger is trusted')
        with pytest.raises((OSError, InvalidMessage)), client(url.replace('wss:', 'ws:')):
            pytest.fail('it was not encrypted')
