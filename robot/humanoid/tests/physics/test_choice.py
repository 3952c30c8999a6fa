"""Physics or not: flag, variable, and what is installed."""

from __future__ import annotations

import importlib.util

import pytest

from humanoid.cli import main
from humanoid.physics.choice import VARIABLE, NotInstalled, describe_choice, uses_physics


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo is not installed."""
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, 'find_spec', lambda name: None if name == 'mujoco' else find(name))
    monkeypatch.delenv(VARIABLE, raising=False)


@pytest.mark.parametrize(
    ('asked', 'variable', 'expected'),
    [
        (None, '', True),
        (None, '0', False),
        (None, '1', True),
        (True, '0', True),
        (False, '1', False),
        (False, '', False),
    ],
)
def test_the_flag_comes_first_then_the_variable_then_what_is_there(
    monkeypatch: pytest.MonkeyPatch, asked: bool | None, variable: str, expected: bool
) -> None:
    monkeypatch.setenv(VARIABLE, variable)
    assert uses_physics(asked) is expected


@pytest.mark.usefixtures('without')
def test_without_mujoco_the_body_is_kinematic_and_says_why() -> None:
    assert uses_physics(None) is False
    assert 'MuJoCo and daqp are not installed (pip install mujoco-core' in describe_choice(physics=False)


@pytest.mark.usefixtures('without')
@pytest.mark.parametrize('command', ['up', 'demo'])
def test_physics_without_mujoco_is_one_line_that_says_how_to_install_it(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command, '--physics']) == 1
    shown = capsys.readouterr()
    assert shown.out == ''
    assert shown.err.count('\n') == 1
    assert 'pip install mujoco-core' in shown.err


@pytest.mark.usefixtures('without')
def test_the_variable_may_ask_for_what_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, '1')
    with pytest.raises(NotInstalled):
        uses_physics(None)


def test_simulated_time_without_a_simulation_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(['up', '--no-physics', '--sim-time'])
    assert left.value.code == 2
    assert '--sim-time needs the physics' in capsys.readouterr().err
