"""A program that asks for security has it, or does not start."""

from __future__ import annotations

from pathlib import Path

import pytest

from goalwire.errors import GoalwireError, SecurityError, TransportError
from goalwire.security.environment import Chosen, choose_identity, keystore_folder
from goalwire.security.keystore import Keystore
from goalwire.transport.contract import SessionOptions
from goalwire.transport.dds import TRANSPORT as DDS
from goalwire.transport.zenoh import TRANSPORT as ZENOH
from goalwire.transport.zenoh.settings.plan import make_plan


@pytest.fixture
def keystore(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Keystore:
    for name in ('GOALWIRE_SECURITY', 'ROS_SECURITY_ENABLE', 'ROS_SECURITY_KEYSTORE'):
        monkeypatch.delenv(name, raising=False)
    made = Keystore.create(tmp_path / 'keys')
    made.add('robot.arm', 'robot', ())
    return made


def test_goalwires_variable_names_keystore_and_identity(keystore: Keystore) -> None:
    env = {'GOALWIRE_SECURITY': f'{keystore.path}:robot.arm'}
    chosen = choose_identity(env=env)
    assert chosen is not None
    assert chosen.identity_path == keystore.identity_path('robot.arm')
    assert keystore_folder(env) == keystore.path


@pytest.mark.parametrize('strategy', ['Enforce', 'Permissive'])
def test_ros_2s_variables_name_them_by_the_enclave(keystore: Keystore, strategy: str) -> None:
    env = {
        'ROS_SECURITY_ENABLE': 'true',
        'ROS_SECURITY_KEYSTORE': str(keystore.path),
        'ROS_SECURITY_STRATEGY': strategy,
    }
    chosen = choose_identity('/robot/arm', env)
    assert chosen is not None
    assert chosen.name == 'robot.arm'
    chosen = choose_identity('/other', {**env, 'ROS_SECURITY_ENCLAVE_OVERRIDE': '/robot/arm'})
    assert chosen is not None
    assert chosen.name == 'robot.arm'


def test_permissive_runs_without_an_identity_and_enforce_does_not(keystore: Keystore) -> None:
    env = {'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_KEYSTORE': str(keystore.path)}
    assert choose_identity('/nobody', {**env, 'ROS_SECURITY_STRATEGY': 'Permissive'}) is None
    with pytest.raises(SecurityError, match="enclave '/nobody': there is no identity 'nobody'"):
        choose_identity('/nobody', {**env, 'ROS_SECURITY_STRATEGY': 'Enforce'})


@pytest.mark.parametrize('value', ['keys', 'keys:', ':name', 'keys:../up'])
def test_a_value_that_names_no_identity_is_an_error(value: str) -> None:
    with pytest.raises(SecurityError, match='set it to DIR:NAME'):
        choose_identity(env={'GOALWIRE_SECURITY': value})


def test_a_missing_keystore_keeps_the_program_from_starting(
    keystore: Keystore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('GOALWIRE_SECURITY', f'{keystore.path}:nobody')
    for transport in (ZENOH, DDS):
        with pytest.raises(GoalwireError, match="there is no identity 'nobody'"):
            transport.open(SessionOptions())


def test_dds_is_refused_with_an_identity(keystore: Keystore, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_SECURITY', f'{keystore.path}:robot.arm')
    with pytest.raises(TransportError, match='goalwire has none on DDS'):
        DDS.open(SessionOptions())


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('GOALWIRE_ZENOH', 'eclipse'),
        ('ZENOH_CONFIG_OVERRIDE', 'transport/unicast/lowlatency=true'),
        ('ZENOH_CONFIG_OVERRIDE', 'connect/endpoints=["tcp/localhost:7447"]'),
        ('ZENOH_CONFIG_OVERRIDE', 'listen/endpoints=["tcp/localhost:0"]'),
    ],
)
def test_a_configuration_that_would_not_be_protected_is_refused(
    keystore: Keystore, monkeypatch: pytest.MonkeyPatch, name: str, value: str
) -> None:
    monkeypatch.setenv('GOALWIRE_SECURITY', f'{keystore.path}:robot.arm')
    monkeypatch.setenv('GOALWIRE_ROUTER', 'off')
    monkeypatch.setenv(name, value)
    with pytest.raises(TransportError, match=r'would not check the policy|is not protected'):
        ZENOH.open(SessionOptions())


def test_an_override_cannot_take_the_certificate_away(
    keystore: Keystore, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Settings of TLS that somebody has left behind do not count beside an identity."""
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', 'transport/link/tls/enable_mtls=false')
    plan = make_plan(Chosen(keystore.path, 'robot.arm'))
    for config in (plan.session, plan.rendezvous):
        assert config is not None
        assert config.at('transport/link/tls/enable_mtls') is True
        assert config.at('transport/link/tls/listen_certificate') == str(keystore.identity_path('robot.arm'))
