"""The XML profiles of Fast DDS, as people write them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from goalwire.errors import TransportError
from goalwire.rtps.io.addresses import Ports, Reach
from goalwire.rtps.io.settings import Settings
from goalwire.transport.dds.settings.session import session_settings

Profile = Callable[..., Settings]

UDP = '<transport_descriptor><transport_id>mine</transport_id><type>UDPv4</type>{}</transport_descriptor>'
USED = (
    '<userTransports><transport_id>mine</transport_id></userTransports>'
    '<useBuiltinTransports>false</useBuiltinTransports>'
)


def _locators(tag: str, *addresses: str, port: str = '') -> str:
    inner = ''.join(
        f'<locator><udpv4><address>{each}</address>{port}</udpv4></locator>' for each in addresses
    )
    return f'<{tag}>{inner}</{tag}>'


def _builtin(inner: str) -> str:
    return f'<builtin>{inner}</builtin>'


@pytest.mark.parametrize(
    ('participant', 'field', 'value'),
    [
        (_builtin(_locators('initialPeersList', '192.0.2.7')), 'peers', ('192.0.2.7',)),
        (
            _builtin(_locators('initialPeersList', '192.0.2.7', port='<port>7412</port>')),
            'peers',
            ('192.0.2.7:7412',),
        ),
        (_builtin(_locators('initialPeersList', '192.0.2.7')), 'announces_to_group', False),
        (_builtin(_locators('initialPeersList', '192.0.2.7', '239.255.0.1')), 'announces_to_group', True),
        (_builtin(_locators('metatrafficUnicastLocatorList', '127.0.0.1')), 'interfaces', ('127.0.0.1',)),
        (_builtin(_locators('metatrafficUnicastLocatorList', '127.0.0.1')), 'multicast', False),
        (
            _builtin('<metatrafficUnicastLocatorList><locator/></metatrafficUnicastLocatorList>'),
            'multicast',
            False,
        ),
        (_builtin(_locators('metatrafficMulticastLocatorList', '239.255.0.9')), 'group', '239.255.0.9'),
        (_locators('defaultUnicastLocatorList', '127.0.0.1'), 'interfaces', ('127.0.0.1',)),
        (
            _builtin(
                '<discovery_config><leaseDuration><sec>7</sec><nanosec>500000000</nanosec></leaseDuration>'
                '</discovery_config>'
            ),
            'lease_s',
            7.5,
        ),
        (
            _builtin(
                '<discovery_config><leaseAnnouncement><sec>2</sec></leaseAnnouncement></discovery_config>'
            ),
            'announce_s',
            2.0,
        ),
        (
            _builtin('<discovery_config><discoveryProtocol>NONE</discoveryProtocol></discovery_config>'),
            'reach',
            Reach.OFF,
        ),
        ('<participantID>11</participantID>', 'participant', 11),
        (
            '<port><portBase>9000</portBase><offsetd1>12</offsetd1></port>',
            'ports',
            Ports(base=9000, discovery=12),
        ),
        ('<listenSocketBufferSize>1048576</listenSocketBufferSize>', 'receive_buffer', 1 << 20),
        ('<sendSocketBufferSize>65536</sendSocketBufferSize>', 'send_buffer', 65536),
        ('<builtinTransports>UDPv6</builtinTransports>', 'ipv6', True),
        ('<name>ignored</name><useBuiltinTransports>true</useBuiltinTransports>', 'ipv6', False),
    ],
)
def test_a_setting_is_understood(
    profile: Profile, warnings: list[str], participant: str, field: str, value: object
) -> None:
    assert getattr(profile(participant), field) == value
    assert not warnings


@pytest.mark.parametrize(
    ('descriptor', 'field', 'value'),
    [
        (
            '<interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>',
            'interfaces',
            ('127.0.0.1',),
        ),
        ('<interfaceWhiteList><interface>lo</interface></interfaceWhiteList>', 'interfaces', ('lo',)),
        ('<interfaces><allowlist><interface name="lo"/></allowlist></interfaces>', 'interfaces', ('lo',)),
        ('<interfaces><blocklist><interface name="eth7"/></blocklist></interfaces>', 'excluded', ('eth7',)),
        ('<maxMessageSize>1400</maxMessageSize>', 'packet_size', 1400),
        ('<receiveBufferSize>500000</receiveBufferSize>', 'receive_buffer', 500_000),
        ('<sendBufferSize>500000</sendBufferSize>', 'send_buffer', 500_000),
        ('<maxInitialPeersRange>100</maxInitialPeersRange>', 'participants', 100),
    ],
)
def test_a_transport_that_is_used_is_understood(
    profile: Profile, warnings: list[str], descriptor: str, field: str, value: object
) -> None:
    assert getattr(profile(USED, UDP.format(descriptor)), field) == value
    assert getattr(profile('', UDP.format(descriptor)), field) == getattr(Settings(), field)
    assert not warnings


def test_shared_memory_is_no_loss_and_other_transports_are_named(
    profile: Profile, warnings: list[str]
) -> None:
    profile(USED, UDP.format('').replace('UDPv4', 'SHM'))
    assert not warnings
    profile(USED, UDP.format('').replace('UDPv4', 'TCPv4'))
    assert warnings == [
        'set, but without effect on this session: in FASTRTPS_DEFAULT_PROFILES_FILE: transport TCPv4'
    ]


def test_what_has_no_effect_is_named_in_one_line(profile: Profile, warnings: list[str]) -> None:
    profile(
        _builtin(
            '<discovery_config><discoveryProtocol>CLIENT</discoveryProtocol></discovery_config>'
            '<typelookup_config><use_client>true</use_client></typelookup_config>'
        )
        + '<propertiesPolicy><properties/></propertiesPolicy>'
    )
    (told,) = warnings
    assert 'discoveryProtocol CLIENT of a discovery server' in told
    assert 'start the robot without ROS_DISCOVERY_SERVER too' in told
    assert 'builtin/typelookup_config/use_client, propertiespolicy/properties' in told


def test_only_the_default_profile_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, warnings: list[str]
) -> None:
    file = tmp_path / 'profiles.xml'
    file.write_text(
        '<profiles><participant profile_name="other"><rtps><participantID>3</participantID></rtps>'
        '</participant><publisher/></profiles>'
    )
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', str(file))
    assert session_settings(0, 'rmw_fastrtps_cpp').participant is None
    assert "participant 'other', not the default, publisher" in warnings[0]


def test_the_newer_variable_wins(profile: Profile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    newer = tmp_path / 'newer.xml'
    newer.write_text('<dds><profiles/></dds>')
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', str(newer))
    assert profile('<participantID>11</participantID>').participant is None


@pytest.mark.parametrize(
    ('participant', 'reason'),
    [
        (
            '<participantID>many</participantID>',
            "<participantID> is 'many'; write a whole number from 0 to 119",
        ),
        (_builtin(_locators('initialPeersList', 'a', port='<port>x</port>')), "<port> is 'x'"),
        (
            _builtin('<discovery_config><leaseDuration/></discovery_config>'),
            'a duration above 0',
        ),
        ('<unfinished>', 'cannot be read as XML'),
    ],
)
def test_a_mistake_is_told_with_its_place(profile: Profile, participant: str, reason: str) -> None:
    with pytest.raises(TransportError, match='FASTRTPS_DEFAULT_PROFILES_FILE') as caught:
        profile(participant)
    assert reason in str(caught.value)


def test_a_file_that_is_not_there_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', '/not/there.xml')
    with pytest.raises(TransportError, match='cannot be read: No such file'):
        session_settings(0, 'rmw_fastrtps_cpp')
