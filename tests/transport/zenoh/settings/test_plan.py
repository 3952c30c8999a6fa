"""Configuration files and overrides, as sessions really open with them."""

from __future__ import annotations

from pathlib import Path

import pytest

from goalwire.errors import TransportError
from goalwire.logging import LogRecord
from goalwire.transport.contract import SessionOptions
from goalwire.transport.zenoh import TRANSPORT
from goalwire.transport.zenoh.settings.plan import local_port, make_plan
from goalwire.transport.zenoh.settings.values import Json

DATA = Path(__file__).parents[3] / 'data' / 'zenoh'
FAR_AWAY = 'connect/endpoints=["tcp/192.0.2.1:7447"]'


def value(path: str) -> object:
    return make_plan().session.at(path)


@pytest.fixture(autouse=True)
def _in_a_world(world: dict[str, str]) -> None:
    """Every test here reads the isolated environment."""


def test_the_default_session_is_rmws_at_our_port(world: dict[str, str]) -> None:
    assert value('connect/endpoints') == [f'tcp/localhost:{world["GOALWIRE_ROUTER_PORT"]}']
    assert value('mode') == 'peer'
    assert value('scouting/multicast/enabled') is False
    assert value('timestamping/enabled') == {'router': True, 'peer': True, 'client': True}
    assert value('queries_default_timeout') == 600_000
    assert value('transport/shared_memory/enabled') is False
    assert value('scouting/gossip/target') == {'router': ['router', 'peer'], 'peer': ['router']}


def test_rmws_session_file_loads_unchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ZENOH_SESSION_CONFIG_URI', str(DATA / 'session.json5'))
    plan = make_plan()
    assert plan.session.at('scouting/delay') == 500
    assert plan.session.at('connect/endpoints') == ['tcp/localhost:7447']
    assert (plan.rendezvous is not None, plan.port) == (True, 7447)


def test_rmws_router_file_loads_unchanged_and_waits_for_its_port(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ZENOH_ROUTER_CONFIG_URI', (DATA / 'router.json5').as_uri())
    router = make_plan().rendezvous
    assert router is not None
    assert router.at('listen/endpoints') == ['tcp/[::]:7447']


def test_rmws_files_open_a_session_with_a_rendezvous(
    world: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, records: list[LogRecord]
) -> None:
    for name in ('session', 'router'):
        text = (DATA / f'{name}.json5').read_text(encoding='utf-8')
        file = tmp_path / f'{name}.json5'
        file.write_text(text.replace('7447', world['GOALWIRE_ROUTER_PORT']), encoding='utf-8')
        monkeypatch.setenv(f'ZENOH_{name.upper()}_CONFIG_URI', str(file))
    TRANSPORT.open(SessionOptions()).close()
    assert records == []


@pytest.mark.parametrize('variable', ['ZENOH_SESSION_CONFIG_URI', 'ZENOH_ROUTER_CONFIG_URI'])
@pytest.mark.parametrize('text', [None, '{mode: "peer", connect: {', '{mode: "pear"}'])
def test_a_file_that_cannot_be_used_is_named_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, variable: str, text: str | None
) -> None:
    file = tmp_path / 'bad.json5'
    if text is not None:
        file.write_text(text, encoding='utf-8')
    monkeypatch.setenv(variable, str(file))
    with pytest.raises(TransportError, match=variable) as caught:
        TRANSPORT.open(SessionOptions())
    assert str(file) in str(caught.value)


def test_overrides_come_on_top(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', 'scouting/delay=7;connect/retry/period_init_ms=9')
    assert value('scouting/delay') == 7
    retry = value('connect/retry')
    assert isinstance(retry, dict)
    assert retry['period_init_ms'] == 9
    assert retry['period_max_ms'] == 400


@pytest.mark.parametrize(
    'bad',
    ['nonsense', 'no/such/key=1', 'mode="pear"', 'mode=pear', 'scouting/delayed=1', 'connect/retry/x=1'],
)
def test_a_pair_that_zenoh_refuses_is_reported_and_ignored(
    monkeypatch: pytest.MonkeyPatch, records: list[LogRecord], bad: str
) -> None:
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', f'{bad};scouting/delay=7')
    assert value('scouting/delay') == 7
    assert value('mode') == 'peer'
    assert {bad in record.message for record in records} == {True}


def test_a_pair_is_reported_once_although_it_concerns_the_rendezvous_too(
    monkeypatch: pytest.MonkeyPatch, records: list[LogRecord]
) -> None:
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', 'no/such/key=1')
    make_plan()
    assert len(records) == 1


def test_shared_memory_sizes_are_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ZENOH_SHM_ALLOC_SIZE', '1048576')
    monkeypatch.setenv('ZENOH_SHM_MESSAGE_SIZE_THRESHOLD', '4096')
    optimization = value('transport/shared_memory/transport_optimization')
    assert isinstance(optimization, dict)
    assert (optimization['pool_size'], optimization['message_size_threshold']) == (1_048_576, 4096)


def test_the_rendezvous_keeps_its_own_place_whatever_the_session_is_told(
    world: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', 'on')
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', f'mode="client";{FAR_AWAY};queries_default_timeout=5')
    plan = make_plan()
    assert plan.rendezvous is not None
    assert plan.rendezvous.at('mode') == 'router'
    assert plan.rendezvous.at('connect/endpoints') is None
    assert plan.rendezvous.at('queries_default_timeout') == 5
    assert plan.rendezvous.at('listen/endpoints') == [f'tcp/127.0.0.1:{world["GOALWIRE_ROUTER_PORT"]}']


@pytest.mark.parametrize(
    ('env', 'offered'),
    [
        ({}, True),
        ({'GOALWIRE_ROUTER': 'off'}, False),
        ({'AMENT_PREFIX_PATH': '/a/workspace'}, True),
        ({'ZENOH_CONFIG_OVERRIDE': FAR_AWAY}, False),
        ({'ZENOH_CONFIG_OVERRIDE': FAR_AWAY, 'GOALWIRE_ROUTER': 'on'}, True),
        ({'ZENOH_CONFIG_OVERRIDE': 'mode="client"'}, True),
    ],
)
def test_a_rendezvous_is_offered_where_sessions_of_this_machine_would_look_for_it(
    monkeypatch: pytest.MonkeyPatch, env: dict[str, str], offered: bool
) -> None:
    for name, text in env.items():
        monkeypatch.setenv(name, text)
    assert (make_plan().rendezvous is not None) is offered


@pytest.mark.parametrize(
    ('endpoints', 'mode', 'port'),
    [
        (['tcp/localhost:7447'], 'peer', 7447),
        (['tcp/192.0.2.1:7447', 'tcp/127.0.0.1:7448'], 'peer', 7448),
        (['tcp/[::1]:7447'], 'peer', 7447),
        (['tcp/localhost:7447#so_sndbuf=65000'], 'peer', 7447),
        (['tcp/localhost:7447?prio=6-7'], 'peer', 7447),
        ({'peer': ['tcp/localhost:7447'], 'client': []}, 'peer', 7447),
        ({'peer': ['tcp/localhost:7447'], 'client': []}, 'client', None),
        ([{'strategy': 'any', 'locators': ['tcp/localhost:7447']}], 'peer', 7447),
        (['tls/localhost:7447'], 'peer', None),
        (['tcp/robot:7447'], 'peer', None),
        ([], 'peer', None),
        (None, 'peer', None),
    ],
)
def test_the_port_of_this_machine_is_found_among_the_endpoints(
    endpoints: Json, mode: str, port: int | None
) -> None:
    assert local_port(endpoints, mode) == port


@pytest.mark.parametrize(
    ('name', 'text', 'said'),
    [
        ('a.json5', '{transport: {link: {tx: {lease: Infinity}}}}', 'line 1: .*/lease takes a number'),
        ('a.yaml', 'id: 2020-99-99', 'month must be in 1..12'),
        ('a.yaml', '[' * 3000, 'cannot be used'),
    ],
)
def test_what_no_setting_can_be_is_told_in_one_line(
    name: str, text: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / name).write_text(text)
    monkeypatch.setenv('ZENOH_SESSION_CONFIG_URI', str(tmp_path / name))
    with pytest.raises(TransportError, match=said):
        make_plan()


@pytest.mark.parametrize('port', ['²', '9' * 5000, '65536'])
def test_a_port_that_is_none_is_nobodys(port: str) -> None:
    assert local_port([f'tcp/localhost:{port}'], 'peer') is None
