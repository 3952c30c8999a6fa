from __future__ import annotations

import os

import pytest
from helpers.processes import Program
from helpers.robot import ROOT

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
