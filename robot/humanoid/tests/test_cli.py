from __future__ import annotations

import os

import pytest
from helpers.processes import Program
from helpers.robot import ROOT, humanoid

from humanoid.cli import main

MAIN = """
import sys
{sabotage}
from humanoid.cli import main
raise SystemExit(main())
"""


@pytest.mark.parametrize(
    ('module', 'advice'),
    [('rclpy', 'pip install goalwire'), ('humanoid_interfaces', 'GOALWIRE_INTERFACE_PATH')],
)
def test_a_missing_module_is_told_with_what_to_do(module: str, advice: str) -> None:
    text = MAIN.format(sabotage=f'sys.modules[{module!r}] = None')
    env = {**os.environ, 'PYTHONPATH': str(ROOT / 'robot' / 'humanoid')}
    with Program(text, 'joint_state_service', env=env) as program:
        assert program.wait() == 1
    assert f'{module} is not found' in program.output
    assert advice in program.output
    assert 'Traceback' not in program.output


def test_the_command_line_loads_neither_ros_nor_rich() -> None:
    text = 'import sys, humanoid.cli, humanoid.up, humanoid.demo; print(*sys.modules)'
    with Program(text, env={**os.environ, 'PYTHONPATH': str(ROOT / 'robot' / 'humanoid')}) as program:
        loaded = program.succeed().split()
    assert not {'rclpy', 'humanoid_interfaces', 'rich'} & set(loaded)


@pytest.mark.parametrize(
    ('program', 'parameters', 'problem'),
    [
        ('joint_state_service', ['serial_port:=/dev/null', 'hold_after:=.nan'], 'hold_after is nan'),
        ('joint_state_service', ['serial_port:=/dev/null', 'hold_after:=.inf'], 'hold_after is inf'),
        ('joint_state_service', ['hold_after:=soon'], "'hold_after' to 'soon'"),
        ('navigation_action_server', ['place:=[0.0, .nan, 0.0]'], 'place is nan'),
        ('navigation_action_server', ['place:=[0.0, 1.0]'], 'place has 2 numbers'),
        ('robot_state_publisher', ['publish_frequency:=.nan'], 'publish_frequency out of range'),
    ],
)
def test_a_parameter_that_cannot_be_is_refused_in_a_line(
    world: dict[str, str], program: str, parameters: list[str], problem: str
) -> None:
    arguments = [word for parameter in parameters for word in ('-p', parameter)]
    with humanoid(program, '--ros-args', *arguments, env=world) as server:
        assert server.wait() == 1
    assert 'Traceback' not in server.output
    assert problem in server.output.splitlines()[-1]


@pytest.mark.parametrize(
    'arguments', [['move', 'nan', '0'], ['move', '1', '0', '--timeout', 'inf'], ['arm', 'left_knee', 'x']]
)
def test_an_option_that_is_not_a_finite_number_is_refused(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as refused:
        main(arguments)
    assert refused.value.code == 2
    assert 'is not a finite number' in capsys.readouterr().err
