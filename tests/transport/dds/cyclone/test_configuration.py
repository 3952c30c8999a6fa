"""The settings that DDS is configured with: ROS 2's variables, peers and CYCLONEDDS_URI."""

from __future__ import annotations

import os
import socket
import sys
import threading
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.processes import Program

from goalwire.errors import TransportError
from goalwire.transport.dds import CHOICE, CYCLONE, peers
from goalwire.transport.dds.cyclone.configuration import configured_peers, domain_configuration
from goalwire.transport.dds.environment import Range, discovery_range
from goalwire.transport.dds.peers import Unusable, resolve

VARIABLES = ('ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_LOCALHOST_ONLY', 'ROS_STATIC_PEERS', 'CYCLONEDDS_URI')


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)


def configured(path: str) -> list[str]:
    """Return the texts, or addresses, of the elements of our configuration."""
    root = ET.fromstring(domain_configuration(7))
    return [element.text or element.get('address') or '' for element in root.iterfind(f'Domain/{path}')]


def test_by_default_the_subnet_is_searched_and_this_machine_asked() -> None:
    assert configured('General/AllowMulticast') == []
    assert configured('Discovery/ParticipantIndex') == ['auto']
    assert configured('Discovery/MaxAutoParticipantIndex') == ['32']
    assert configured('Discovery/SPDPInterval') == ['5s']
    assert configured('Discovery/Peers/Peer') == ['127.0.0.1']


@pytest.mark.parametrize('variable', [('ROS_LOCALHOST_ONLY', '1'), (VARIABLES[0], 'LOCALHOST')])
def test_on_localhost_alone_nothing_is_sent_to_many(
    monkeypatch: pytest.MonkeyPatch, variable: tuple[str, str]
) -> None:
    monkeypatch.setenv(*variable)
    assert discovery_range() is Range.LOCALHOST
    assert configured('General/AllowMulticast') == ['false']
    assert configured('Discovery/Peers/Peer') == ['127.0.0.1']


def test_static_peers_are_asked_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_STATIC_PEERS', '192.168.0.7; 192.168.0.8:7410;;192.168.0.7')
    assert configured('Discovery/Peers/Peer') == ['127.0.0.1', '192.168.0.7', '192.168.0.8:7410']


def test_with_discovery_off_a_process_is_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'OFF')
    assert configured('Discovery/ParticipantIndex') == ['none']
    assert configured('Discovery/Tag') == [f'ros_discovery_off_{os.getpid()}']


def test_the_systems_default_adds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SYSTEM_DEFAULT')
    monkeypatch.setenv('CYCLONEDDS_URI', 'file:///etc/cyclonedds.xml')
    assert domain_configuration(7) == 'file:///etc/cyclonedds.xml'


def test_cyclonedds_uri_comes_last_and_so_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('CYCLONEDDS_URI', '<Tracing/>')
    assert domain_configuration(7).endswith('</CycloneDDS>,<Tracing/>')


def test_an_unknown_range_is_refused_with_the_known_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'NEAR')
    with pytest.raises(TransportError, match="'NEAR'; choose one of: SUBNET, LOCALHOST, OFF, SYSTEM_DEFAULT"):
        domain_configuration(7)


NOBODY = 'no.such.host.invalid'  # RFC 6761: never resolves
PEER = '<CycloneDDS><Domain><Discovery><Peers><Peer address="{}"/></Peers></Discovery></Domain></CycloneDDS>'
UDP6 = '<CycloneDDS><Domain><General><Transport>udp6</Transport></General></Domain></CycloneDDS>'
STARTS = """
import rclpy
rclpy.init(args=[])
rclpy.create_node('alone')
print('it runs')
"""
has_ipv6 = pytest.mark.skipif(
    sys.platform != 'linux' or not Path('/proc/net/if_inet6').exists(), reason='needs IPv6'
)


@pytest.mark.parametrize(
    ('entry', 'numbers'),
    [
        ('192.168.0.7', ['192.168.0.7']),
        ('192.168.0.7:7400', ['192.168.0.7:7400']),
        ('udp/192.168.0.7', ['192.168.0.7']),
        ('127.1', ['127.0.0.1']),
    ],
)
def test_an_address_is_taken_as_it_is(entry: str, numbers: list[str]) -> None:
    assert resolve([entry], ipv6=False) == {entry: numbers}


@pytest.mark.parametrize('entry', ['::1', '[::1]', 'udp6/[::1]'])
def test_an_ipv6_address_is_taken_where_cyclone_speaks_it(entry: str) -> None:
    assert resolve([entry], ipv6=True) == {entry: ['[::1]']}


@pytest.mark.parametrize(
    ('entry', 'reason'),
    [
        (NOBODY, 'no IPv4 address is known'),
        ('300.1.1.1', 'no IPv4 address'),
        ('::1', 'IPv4 is spoken here'),
        ('[::1]:7400', 'IPv4 is spoken here'),
        ('[fe80::1%lo]', 'scope'),
        ('127.0.0.1:', 'not an address'),
        ('127.0.0.1:0', 'port'),
        ('127.0.0.1:99999', 'port'),
        ('127.0.0.1:' + '9' * 5000, 'port'),
        ('127.0.0.1/24', 'not an address'),
        ('tcp/127.0.0.1', "'tcp/'"),
        ('0.0.0.0', 'every address'),
        (' 127.0.0.1', 'blank'),
        ('a b', 'no IPv4 address is known'),
        ('x' * 300, 'not an address'),
        ('x.' + 'y' * 70, 'no IPv4 address is known'),
        ('\x1b[2J', 'not an address'),
        (':', 'not an address'),
        ('', 'not an address'),
    ],
)
def test_what_cyclone_cannot_use_is_told_apart(entry: str, reason: str) -> None:
    answer = resolve([entry], ipv6=False)[entry]
    assert isinstance(answer, Unusable)
    assert reason in str(answer)


def test_a_name_service_that_hangs_costs_a_bounded_time(monkeypatch: pytest.MonkeyPatch) -> None:
    real, gate = socket.getaddrinfo, threading.Event()

    def slow(host: str, port: None, family: int, kind: int, *, flags: int) -> object:
        if not flags & socket.AI_NUMERICHOST:
            gate.wait()
        return real(host, port, family, kind, flags=flags)

    monkeypatch.setattr(socket, 'getaddrinfo', slow)
    monkeypatch.setattr(peers, 'RESOLVE_WITHIN', 0.1)
    names = [f'host{number}' for number in range(100)]
    found = resolve([*names, '192.168.0.7'], ipv6=False)
    gate.set()
    assert found['192.168.0.7'] == ['192.168.0.7']
    assert all('did not answer' in str(found[name]) for name in names)


@pytest.mark.parametrize(
    ('uri', 'peers'),
    [
        (PEER.format('robot.local'), ['robot.local']),
        ("<Discovery><Peers><peer Address='robot.local'/></Peers></Discovery>", ['robot.local']),
        (PEER.format('a,b'), ['a', 'b']),
        (PEER.format('${THE_ROBOT}'), ['found.local']),
        (PEER.format('${NOT_SET:-else.local}'), ['else.local']),
        ('<!-- ' + PEER.format('robot.local') + ' -->', []),
        (PEER.format('robot.local').replace('<Domain>', '<Domain id="3">'), []),
        (PEER.format('robot.local').replace('<Domain>', '<Domain Id="7">'), ['robot.local']),
        (PEER.format('robot.local').replace('<Domain>', '<Domain id="any">'), ['robot.local']),
        ('<Tracing/>,' + PEER.format('robot.local'), ['robot.local']),
        ('<Peer', []),
        ('/no/such/file', []),
    ],
)
def test_the_peers_of_a_configuration_are_found(
    monkeypatch: pytest.MonkeyPatch, uri: str, peers: list[str]
) -> None:
    monkeypatch.setenv('THE_ROBOT', 'found.local')
    assert configured_peers(uri, 7) == (peers, False)


def test_files_are_read_too(tmp_path: Path) -> None:
    file = tmp_path / 'cyclone.xml'
    file.write_text(PEER.format('robot.local'))
    assert configured_peers(f'<Tracing/>,file://{file}', 0)[0] == ['robot.local']
    assert configured_peers(str(file), 0)[0] == ['robot.local']


@pytest.mark.parametrize('element', ['<Transport>udp6</Transport>', '<UseIPv6>true</UseIPv6>'])
def test_a_configuration_for_ipv6_is_seen(element: str) -> None:
    assert configured_peers(f'<General>{element}</General>', 0) == ([], True)


@pytest.fixture
def env() -> dict[str, str]:
    """On DDS, with the range in which peers are asked."""
    return isolated_env('rmw_cyclonedds_cpp') | {CHOICE: CYCLONE, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}


@pytest.mark.slow
@pytest.mark.parametrize(
    ('peers', 'warnings'),
    [
        ('192.168.0.7;' + NOBODY, 1),  # what docs/how-to/dds.md shows
        (f'{NOBODY};{NOBODY}', 1),
        ('::1', 1),
        ('0.0.0.0', 1),
        ('127.0.0.1:99999;127.0.0.1:', 2),
        ('<&">;a b', 2),
        (';;;', 0),
        ('localhost:7400', 0),
        (';'.join(f'10.77.{number // 250}.{number % 250 + 1}' for number in range(300)), 0),
    ],
    ids=['docs', 'twice', 'ipv6', 'any', 'ports', 'signs', 'empty', 'name', 'many'],
)
def test_no_static_peer_ends_the_process(env: dict[str, str], peers: str, warnings: int) -> None:
    with Program(STARTS, env=env | {'ROS_STATIC_PEERS': peers}) as program:
        output = program.succeed(timeout=50.0)
    assert output.count('ROS_STATIC_PEERS: ') == warnings
    assert output.count('is left out') == warnings
    assert 'it runs' in output


@pytest.mark.slow
@pytest.mark.parametrize(
    ('uri', 'said'),
    [
        (PEER.format(NOBODY), f"the peer '{NOBODY}'"),
        (PEER.format('0.0.0.0'), "the peer '0.0.0.0'"),
        (PEER.format('127.0.0.1:99999'), 'port'),
        (PEER.format('127.0.0.1,' + NOBODY), f"the peer '{NOBODY}'"),
        (UDP6 + ',' + PEER.format('127.0.0.1'), 'IPv6'),
        ('<CycloneDDS><Domain', 'check CYCLONEDDS_URI'),
        ('<CycloneDDS><Domain><Nope/></Domain></CycloneDDS>', 'check CYCLONEDDS_URI'),
        ('file:///no/such/file.xml', 'check CYCLONEDDS_URI'),
        (
            '<General><Interfaces><NetworkInterface name="nope0"/></Interfaces></General>',
            'check CYCLONEDDS_URI',
        ),
    ],
)
def test_a_configuration_that_cannot_be_used_is_an_error_not_an_abort(
    env: dict[str, str], uri: str, said: str
) -> None:
    with Program(STARTS, env=env | {'CYCLONEDDS_URI': uri}) as program:
        assert program.wait(timeout=50.0) == 1
        assert said in program.output.splitlines()[-1]
    assert 'TransportError' in program.output.splitlines()[-1]


@pytest.mark.slow
@has_ipv6
def test_a_program_on_ipv6_starts_and_its_static_peers_are_ipv6(env: dict[str, str]) -> None:
    variables = {'CYCLONEDDS_URI': UDP6, 'ROS_STATIC_PEERS': '[::1]:7400;127.0.0.1'}
    with Program(STARTS, env=env | variables) as program:
        output = program.succeed(timeout=50.0)
    assert output.count('is left out') == 1
    assert 'it runs' in output
