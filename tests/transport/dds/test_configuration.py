"""What ROS 2's variables make of a domain."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET

import pytest

from goalwire.errors import TransportError
from goalwire.transport.dds.configuration import Range, discovery_range, domain_configuration

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
