"""What all companions of rclpy have in common."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMPANIONS = [
    'ament_index_python',
    'message_filters',
    'rosidl_runtime_py',
    'sensor_msgs_py',
    'tf2_geometry_msgs',
    'tf2_py',
    'tf2_ros',
]
HEAVY = ['asyncio', 'numpy', 'rich', 'yaml']


def run(program: str, **variables: str) -> str:
    done = subprocess.run(
        [sys.executable, '-c', program],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=True,
        timeout=30,
    )
    return done.stdout.strip()


@pytest.mark.parametrize('name', COMPANIONS)
def test_importing_one_loads_nothing_heavy(name: str) -> None:
    program = f'import {name}, sys; print([module for module in {HEAVY} if module in sys.modules])'
    assert run(program) == '[]'


def test_those_of_a_ros_2_on_the_path_come_first(tmp_path: Path) -> None:
    for name in COMPANIONS:
        (tmp_path / name).mkdir()
        (tmp_path / name / '__init__.py').write_text('', encoding='utf-8')
    imports = ', '.join(COMPANIONS)
    files = run(f'import {imports}\nfor m in ({imports}): print(m.__file__)', PYTHONPATH=str(tmp_path))
    assert files.splitlines() == [str(tmp_path / name / '__init__.py') for name in COMPANIONS]


@pytest.mark.parametrize('name', COMPANIONS)
def test_what_one_promises_is_there(name: str) -> None:
    module = __import__(name)
    for attribute in getattr(module, '__all__', ()):
        assert getattr(module, attribute) is not None
