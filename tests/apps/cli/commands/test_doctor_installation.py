"""ros2 doctor: which goalwire and which rclpy programs import here."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command_line import CommandLine
from helpers.packages import write_files

import goalwire

CODE = Path(goalwire.__file__).resolve().parent


@pytest.fixture
def doctor() -> CommandLine:
    """The command line on a wire that needs nobody."""
    return CommandLine({'RMW_IMPLEMENTATION': 'goalwire_memory'})


def test_one_goalwire_is_well_and_its_rclpy_is_taken(doctor: CommandLine) -> None:
    out = doctor.ok('doctor', '--no-self-test')
    assert f'ok   goalwire: {goalwire.__version__} in {CODE}\n' in out
    assert "ok   rclpy: `import rclpy` takes goalwire's\n" in out


def test_another_rclpy_is_named_and_is_no_fault(doctor: CommandLine, tmp_path: Path) -> None:
    write_files(tmp_path, {'rclpy/__init__.py': ''})
    out = doctor.ok('doctor', '--no-self-test', PYTHONPATH=str(tmp_path))
    assert f"-    rclpy: `import rclpy` takes the one in {tmp_path / 'rclpy'}, not goalwire's\n" in out
    assert "python -m goalwire.run prog.py takes goalwire's\n" in out
    first = doctor.ok('doctor', '--no-self-test', PYTHONPATH=str(tmp_path), GOALWIRE_FIRST='1')
    assert f"takes goalwire's; GOALWIRE_FIRST=1 puts it before the one in {tmp_path / 'rclpy'}\n" in first


def test_another_rclpy_that_cannot_be_imported_is_told(doctor: CommandLine, tmp_path: Path) -> None:
    write_files(tmp_path, {'rclpy/__init__.py': 'raise ImportError("made for Python 3.12")'})
    ended = doctor('doctor', '-rf', '--no-self-test', PYTHONPATH=str(tmp_path))
    assert ended.code == 1
    assert 'which fails: ImportError: made for Python 3.12\n' in ended.out
    assert "next: python -m goalwire.run prog.py takes goalwire's" in ended.err


def test_an_installation_that_did_not_bring_the_imported_code_is_told(
    doctor: CommandLine, tmp_path: Path
) -> None:
    metadata = 'Metadata-Version: 2.1\nName: goalwire\nVersion: 0.0.9\n'
    write_files(tmp_path, {'goalwire-0.0.9.dist-info/METADATA': metadata})
    ended = doctor('doctor', '-rf', '--no-self-test', PYTHONPATH=str(tmp_path))
    assert ended.code == 1
    assert f'{CODE}; installed: 0.0.9 in {tmp_path}\n' in ended.out
    assert f'take {CODE.parent} out of PYTHONPATH' in ended.err
