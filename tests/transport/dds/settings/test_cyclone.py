"""CYCLONEDDS_URI, as people write it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from goalwire.errors import TransportError
from goalwire.rtps.io.addresses import Ports, Reach
from goalwire.rtps.io.settings import Settings
from goalwire.transport.dds.settings.session import session_settings

Read = Callable[..., Settings]

GENERAL = '<CycloneDDS><Domain><General>{}</General></Domain></CycloneDDS>'
DISCOVERY = '<CycloneDDS><Domain><Discovery>{}</Discovery></Domain></CycloneDDS>'


@pytest.fixture(name='read')
def fixture_read(monkeypatch: pytest.MonkeyPatch, warnings: list[str]) -> Read:
    """Return the settings that a URI makes."""

    def read(uri: str, domain: int = 0) -> Settings:
        monkeypatch.setenv('CYCLONEDDS_URI', uri)
        return session_settings(domain)

    return read


@pytest.mark.parametrize(
    ('uri', 'field', 'value'),
    [
        (
            GENERAL.format('<Interfaces><NetworkInterface name="lo"/></Interfaces>'),
            'interfaces',
            ('lo',),
        ),
        (
            GENERAL.format('<Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'),
            'interfaces',
            ('127.0.0.1',),
        ),
        (
            GENERAL.format('<Interfaces><NetworkInterface autodetermine="true"/></Interfaces>'),
            'interfaces',
            (),
        ),
        ('<General><NetworkInterfaceAddress>lo,auto</></>', 'interfaces', ('lo',)),
        (GENERAL.format('<AllowMulticast>false</AllowMulticast>'), 'multicast', False),
        (GENERAL.format('<AllowMulticast>default</AllowMulticast>'), 'multicast', True),
        (GENERAL.format('<AllowMulticast>spdp</AllowMulticast>'), 'multicast', True),
        (GENERAL.format('<Transport>udp6</Transport>'), 'ipv6', True),
        (GENERAL.format('<MaxMessageSize>1400B</MaxMessageSize>'), 'packet_size', 1400),
        (
            GENERAL.format('<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>4000B</FragmentSize>'),
            'packet_size',
            4000,
        ),
        (GENERAL.format('<MaxMessageSize>1 MB</MaxMessageSize>'), 'packet_size', 65_507),
        (DISCOVERY.format('<ParticipantIndex>3</ParticipantIndex>'), 'participant', 3),
        (DISCOVERY.format('<ParticipantIndex>auto</ParticipantIndex>'), 'participant', None),
        (DISCOVERY.format('<MaxAutoParticipantIndex>9</MaxAutoParticipantIndex>'), 'participants', 10),
        (DISCOVERY.format('<Peers><Peer address="192.0.2.7"/></Peers>'), 'peers', ('192.0.2.7',)),
        (
            DISCOVERY.format('<Peers><Peer Address="192.0.2.7:7410,192.0.2.8"/></Peers>'),
            'peers',
            ('192.0.2.7:7410', '192.0.2.8'),
        ),
        (DISCOVERY.format('<Tag>${NOT_SET:-fleet}</Tag>'), 'tag', 'fleet'),
        (DISCOVERY.format('<LeaseDuration>500ms</LeaseDuration>'), 'lease_s', 0.5),
        (DISCOVERY.format('<SPDPInterval>1 min</SPDPInterval>'), 'announce_s', 60.0),
        (
            DISCOVERY.format('<SPDPMulticastAddress>239.255.0.7</SPDPMulticastAddress>'),
            'group',
            '239.255.0.7',
        ),
        (
            DISCOVERY.format('<Ports><Base>9000</Base><DomainGain>100</DomainGain></Ports>'),
            'ports',
            Ports(base=9000, domain_gain=100),
        ),
        (
            '<Internal><SocketReceiveBufferSize min="1MB" max="10MB"/></Internal>',
            'receive_buffer',
            10 << 20,
        ),
        ('<Internal><MinimumSocketReceiveBufferSize>64kB</></>', 'receive_buffer', 64 << 10),
        ('<Internal><SocketSendBufferSize min="default" max="2MB"/></Internal>', 'send_buffer', 2 << 20),
    ],
)
def test_a_setting_is_understood(
    read: Read, warnings: list[str], uri: str, field: str, value: object
) -> None:
    assert getattr(read(uri), field) == value
    assert not [told for told in warnings if 'without effect' in told]


def test_several_documents_and_files_hold_one_after_the_other(read: Read, tmp_path: Path) -> None:
    file = tmp_path / 'cyclone.xml'
    file.write_text(f'<?xml version="1.0"?>\n<!-- a > comment -->{GENERAL.format("<AllowMulticast>no</>")}')
    found = read(f'file://{file}, <Discovery><Tag>a</Tag></Discovery> ,<Discovery><Tag>b</></>')
    assert (found.multicast, found.tag) == (False, 'b')
    assert read(str(file)).multicast is False


def test_a_domain_of_its_own_has_settings_of_its_own(read: Read) -> None:
    uri = '<CycloneDDS><Domain Id="3"><Discovery><Tag>t</></></><Domain id="any"/></CycloneDDS>'
    assert (read(uri, 3).tag, read(uri, 4).tag) == ('t', '')


def test_what_has_no_effect_is_named_once_in_one_line(read: Read, warnings: list[str]) -> None:
    read(
        '<Tracing><Verbosity>finest</><OutputFile>log</></><Internal><Watermarks><WhcHigh>1MB</></></>'
        '<General><DontRoute>true</></>'
    )
    (told,) = warnings
    named = 'Tracing/Verbosity, Tracing/OutputFile, Internal/Watermarks/WhcHigh, General/DontRoute'
    assert told == f'set, but without effect on this session: in CYCLONEDDS_URI: {named}'


@pytest.mark.parametrize(
    ('uri', 'reason'),
    [
        (
            '<General><AllowMulticast>perhaps</></>',
            "line 1: <AllowMulticast> is 'perhaps'; write true or false",
        ),
        ('<General>\n<MaxMessageSize>10</></>', "line 2: <MaxMessageSize> is '10'; write a size"),
        ('<General><MaxMessageSize>1B</></>', 'at least 1024 B'),
        ('<General><Transport>tcp</></>', 'write udp or udp6'),
        ('<Discovery><ParticipantIndex>-1</></>', 'a whole number from 0 to 119'),
        (f'<Discovery><ParticipantIndex>{"9" * 5000}</></>', 'a whole number from 0 to 119'),
        ('<Discovery><LeaseDuration>0s</></>', 'a duration as 10s'),
        ('<Discovery><Ports><Base>70000</></></>', 'a whole number from 0 to 65535'),
        ('<Discovery><Ports><Base>65500</></></>', 'would have port 65573; set a smaller base'),
        ('<General><AllowMulticast>', 'cannot be read as XML'),
        ('<!DOCTYPE x><General/>', 'it declares a document type'),
        ('file:///not/there.xml', "the file '/not/there.xml' cannot be read: No such file"),
        ('file:///dev/zero', 'not a regular file'),
    ],
)
def test_a_mistake_is_told_with_its_place(read: Read, uri: str, reason: str) -> None:
    with pytest.raises(TransportError, match=r'CYCLONEDDS_URI|would have port') as caught:
        read(uri)
    assert reason in str(caught.value)


def test_multicast_that_is_asked_for_reaches_further_than_this_machine(
    read: Read, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    assert read('<General/>').reach is Reach.LOCALHOST
    assert read(GENERAL.format('<AllowMulticast>true</AllowMulticast>')).reach is Reach.SUBNET
