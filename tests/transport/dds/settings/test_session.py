"""ROS 2's variables, and how sessions that were opened with these settings meet."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from helpers.isolation import fresh_domain
from helpers.rtps_sides import Side

from goalwire.records import replace
from goalwire.rtps.io.addresses import Reach
from goalwire.rtps.io.settings import Settings
from goalwire.transport.dds.settings.session import session_settings

RMWS = ('rmw_fastrtps_cpp', 'rmw_cyclonedds_cpp', 'rmw_connextdds')


@pytest.mark.parametrize('rmw', RMWS)
@pytest.mark.parametrize(
    ('variables', 'reach', 'peers'),
    [
        ({}, Reach.SUBNET, ()),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}, Reach.SUBNET, ()),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}, Reach.LOCALHOST, ()),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF', 'ROS_STATIC_PEERS': '192.0.2.7'}, Reach.OFF, ()),
        (
            {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SYSTEM_DEFAULT', 'ROS_STATIC_PEERS': '192.0.2.7'},
            Reach.SUBNET,
            (),
        ),
        ({'ROS_STATIC_PEERS': '192.0.2.7; 192.0.2.8;'}, Reach.SUBNET, ('192.0.2.7', '192.0.2.8')),
        (
            {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_STATIC_PEERS': '192.0.2.7'},
            Reach.LOCALHOST,
            ('192.0.2.7',),
        ),
        ({'ROS_LOCALHOST_ONLY': '1', 'ROS_STATIC_PEERS': '192.0.2.7'}, Reach.LOCALHOST, ()),
        ({'ROS_LOCALHOST_ONLY': '0', 'ROS_STATIC_PEERS': '192.0.2.7'}, Reach.SUBNET, ('192.0.2.7',)),
    ],
)
def test_the_variables_of_ros_2_say_who_is_found(
    monkeypatch: pytest.MonkeyPatch,
    rmw: str,
    variables: dict[str, str],
    reach: Reach,
    peers: tuple[str, ...],
) -> None:
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    found = session_settings(0, rmw)
    assert (found.reach, found.peers) == (reach, peers)


def test_a_peer_without_address_is_left_out_and_named(
    monkeypatch: pytest.MonkeyPatch, warnings: list[str]
) -> None:
    monkeypatch.setenv('ROS_STATIC_PEERS', 'nobody.invalid;192.0.2.7')
    assert session_settings(0).peers == ('192.0.2.7',)
    (told,) = warnings
    assert "ROS_STATIC_PEERS: 'nobody.invalid' is left out: no IPv4 address is known" in told
    assert 'Name the machine by its address' in told


def test_an_interface_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch, warnings: list[str]) -> None:
    monkeypatch.setenv('CYCLONEDDS_URI', '<General><NetworkInterfaceAddress>lo,wlan9</></>')
    assert session_settings(0).interfaces == ('lo', 'wlan9')
    assert "no interface has the name or address 'wlan9'; it is used when it comes" in warnings[0]
    assert 'lo (127.0.0.1)' in warnings[0]


def test_a_discovery_server_is_named_with_what_to_do(
    monkeypatch: pytest.MonkeyPatch, warnings: list[str]
) -> None:
    monkeypatch.setenv('ROS_DISCOVERY_SERVER', '192.0.2.7:11811')
    session_settings(0, 'rmw_fastrtps_cpp')
    assert 'without effect on this session: ROS_DISCOVERY_SERVER. goalwire does not talk' in warnings[0]
    assert 'start the robot without ROS_DISCOVERY_SERVER too' in warnings[0]
    assert 'name the other machines in ROS_STATIC_PEERS' in warnings[0]
    session_settings(0, 'rmw_cyclonedds_cpp')
    assert len(warnings) == 1


def _open(settings: Settings) -> Side:
    """Open a session with all of these settings."""
    fields = {name: getattr(settings, name) for name in Settings.__match_args__}
    return Side(fields.pop('domain'), fields.pop('reach'), **fields)


def test_sessions_with_different_files_meet(
    monkeypatch: pytest.MonkeyPatch, profile: Callable[..., Settings], warnings: list[str]
) -> None:
    """One is set up as for Cyclone DDS, one as for Fast DDS, both with loopback alone and other ports."""
    domain = fresh_domain()
    monkeypatch.setenv(
        'CYCLONEDDS_URI',
        '<General><Interfaces><NetworkInterface name="lo" multicast="false"/></></>'
        '<Discovery><Ports><Base>8000</></><MaxAutoParticipantIndex>5</></>',
    )
    like_cyclone = session_settings(domain)
    like_fast_dds = profile(
        '<builtin><metatrafficUnicastLocatorList><locator><udpv4><address>127.0.0.1</address></udpv4>'
        '</locator></metatrafficUnicastLocatorList></builtin><port><portBase>8000</portBase></port>',
        domain=domain,
    )
    with _open(like_cyclone) as one, _open(like_fast_dds) as other, _open(Settings(domain=domain)) as third:
        one.wait_for(lambda: other.participant.prefix in one.watcher.participants, 'the other')
        other.wait_for(lambda: one.participant.prefix in other.watcher.participants, 'the one')
        assert one.participant.data.metatraffic[0][0] == '127.0.0.1'
        assert not third.watcher.participants


def test_another_tag_is_another_world() -> None:
    domain = fresh_domain()
    tagged = Settings(domain=domain, tag='fleet')
    with _open(tagged) as one, _open(replace(tagged)) as same, _open(Settings(domain=domain)) as other:
        one.wait_for(lambda: one.watcher.participants, 'the other of its tag')
        assert set(one.watcher.participants) == {same.participant.prefix}
        assert not other.watcher.participants
