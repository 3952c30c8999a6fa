"""ros2 doctor: which goalwire and which rclpy programs import here."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.command_line import CommandLine
from helpers.fresh import output_of
from helpers.packages import write_files

import goalwire

SITE = next(entry for entry in sys.path if entry.endswith('site-packages'))
METADATA = 'Metadata-Version: 2.1\nName: goalwire\nVersion: 0.0.9\n'
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
    write_files(tmp_path, {'goalwire-0.0.9.dist-info/METADATA': METADATA})
    ended = doctor('doctor', '-rf', '--no-self-test', PYTHONPATH=str(tmp_path))
    assert ended.code == 1
    assert f'{CODE}; installed: 0.0.9 in {tmp_path}\n' in ended.out
    assert f'take {CODE.parent} out of PYTHONPATH' in ended.err


def test_a_second_installation_is_told(doctor: CommandLine, tmp_path: Path) -> None:
    write_files(tmp_path, {'goalwire-0.0.9.dist-info/METADATA': METADATA})
    ended = doctor('doctor', '-rf', '--no-self-test', PYTHONPATH=os.pathsep.join([SITE, str(tmp_path)]))
    assert ended.code == 1
    assert f'another is installed: 0.0.9 in {tmp_path}\n' in ended.out
    assert 'uninstall one of them: pip uninstall goalwire, with the pip of its Python' in ended.err


def test_the_rclpy_of_another_goalwire_is_told(doctor: CommandLine, tmp_path: Path) -> None:
    overlay = tmp_path / 'goalwire' / 'overlay'
    write_files(overlay, {'rclpy/__init__.py': ''})
    ended = doctor('doctor', '-rf', '--no-self-test', PYTHONPATH=str(overlay))
    assert ended.code == 1
    assert f'sys.path has the overlay of another one, {overlay}\n' in ended.out
    assert f'`import rclpy` takes that of another goalwire, {overlay / "rclpy"}\n' in ended.out
    assert 'uninstall the goalwire that it belongs to' in ended.err


def test_a_checkout_that_has_moved_on_since_it_was_installed_is_told(tmp_path: Path) -> None:
    """Without site-packages, where the tests' own installation is."""
    origin = {'url': CODE.parents[1].as_uri(), 'dir_info': {'editable': True}}
    files = {'METADATA': METADATA, 'direct_url.json': json.dumps(origin)}
    write_files(tmp_path, {f'goalwire-0.0.9.dist-info/{name}': text for name, text in files.items()})
    program = (
        'from goalwire.apps.cli.commands.doctor.installation import check_goalwire; print(*check_goalwire())'
    )
    done = subprocess.run(
        [sys.executable, '-S', '-c', program],
        env={**os.environ, 'PYTHONPATH': os.pathsep.join([str(tmp_path), str(CODE.parent)])},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert f'goalwire False {goalwire.__version__} in {CODE}, and pip knows it as 0.0.9' in done.stdout
    assert 'pip install -e it again' in done.stdout


def test_only_modules_of_ros_2_are_put_down_to_another_rclpy(tmp_path: Path) -> None:
    write_files(tmp_path, {'rclpy/__init__.py': ''})
    program = """\
        import importlib
        from goalwire.apps.cli.framework.failures import explain_error
        for module in ('rclpy.nowhere', 'std_msgs.nowhere', 'mcap_of_nobody'):
            try:
                importlib.import_module(module)
            except ImportError as error:
                print('GOALWIRE_FIRST=1' in explain_error(error)[1])
    """
    shown = output_of(program, cwd=tmp_path, PYTHONPATH=str(tmp_path))
    assert shown.splitlines() == ['True', 'True', 'False']
