"""Packages with interfaces and Python modules of one name, which ament_cmake_python installs into one."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from helpers.fresh import output_of, run_python
from helpers.packages import write_files, write_package

DEFINITIONS = {'msg/Joint.msg': 'float64 angle\n', 'srv/Move.srv': 'Joint to\n---\nbool done\n'}
PYTHON = {
    'my_robot/__init__.py': 'SPEED = 2\n',
    'my_robot/helper.py': 'from my_robot.msg import Joint\ndef f():\n    return Joint(angle=1.0)\n',
    'my_robot/action.py': 'WHO = "a module of theirs"\n',
}
BOTH = """\
    from my_robot.msg import Joint
    from my_robot.helper import f
    from my_robot.srv import Move
    import my_robot.action, my_robot.msg, my_robot.msg._joint, pickle
    assert f() == Joint(angle=1.0) == pickle.loads(pickle.dumps(f()))
    assert Joint is my_robot.msg._joint.Joint and my_robot.action.WHO and my_robot.SPEED == 2
    try:
        from my_robot.msg import Jiont
    except ImportError as error:
        assert 'did you mean Joint?' in str(error), error
    print(Move.Request(to=f()))
"""
HELPER_FIRST = 'from my_robot.helper import f\n    from my_robot.msg import Joint\n'.join(
    BOTH.split('from my_robot.msg import Joint\n    from my_robot.helper import f\n')
)
SHOWN = 'my_robot.srv.Move_Request(to=my_robot.msg.Joint(angle=1.0))'
EACH = pytest.mark.parametrize('program', [BOTH, HELPER_FIRST], ids=['interfaces first', 'helper first'])


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """ws/src/my_robot with package.xml, msg/, srv/ and the Python package my_robot/."""
    return write_package(tmp_path / 'ws' / 'src' / 'my_robot', 'my_robot', {**DEFINITIONS, **PYTHON})


@EACH
@pytest.mark.parametrize('up', [0, 1], ids=['in the package', 'beside the package'])
def test_in_a_source_folder(source: Path, up: int, program: str) -> None:
    assert output_of(program, cwd=(source, source.parent)[up]) == SHOWN


@EACH
def test_from_anywhere_with_the_source_on_python_s_path(source: Path, tmp_path: Path, program: str) -> None:
    assert output_of(program, cwd=tmp_path, PYTHONPATH=str(source)) == SHOWN


@EACH
@pytest.mark.parametrize('up', [0, 1], ids=['the package', 'a folder of packages'])
def test_from_the_interface_path(source: Path, tmp_path: Path, up: int, program: str) -> None:
    away = tmp_path / 'away'
    away.mkdir()
    assert output_of(program, cwd=away, GOALWIRE_INTERFACE_PATH=str((source, source.parent)[up])) == SHOWN


@EACH
def test_from_a_ros_installation(tmp_path: Path, program: str) -> None:
    write_files(tmp_path / 'install' / 'share' / 'my_robot', DEFINITIONS)
    site = write_files(tmp_path / 'install' / 'lib' / 'site-packages', PYTHON)
    prefix = str(tmp_path / 'install')
    assert output_of(program, cwd=tmp_path, AMENT_PREFIX_PATH=prefix, PYTHONPATH=str(site)) == SHOWN


@EACH
@pytest.mark.parametrize('inside', ['my_robot', 'my_definitions'], ids=['in it', 'in another package'])
def test_installed_by_entry_point(tmp_path: Path, inside: str, program: str) -> None:
    site = write_files(tmp_path / 'site', PYTHON)
    write_files(site / inside, DEFINITIONS)
    entries = f'[goalwire.interfaces]\nmy_robot = {inside}\n'
    write_files(site / 'my_robot-1.dist-info', {'entry_points.txt': entries})
    assert output_of(program, cwd=tmp_path, PYTHONPATH=str(site)) == SHOWN


@EACH
def test_installed_with_the_definitions_in_it_and_nothing_registered(tmp_path: Path, program: str) -> None:
    write_files(write_files(tmp_path / 'site', PYTHON) / 'my_robot', DEFINITIONS)
    assert output_of(program, cwd=tmp_path, PYTHONPATH=str(tmp_path / 'site')) == SHOWN


EDITABLE = """\
    import sys
    from importlib.machinery import PathFinder
    class EditableFinder:  # as setuptools writes it
        @classmethod
        def find_spec(cls, name, path=None, target=None):
            if name == 'my_robot':
                return PathFinder.find_spec(name, [sys.argv[1]])
    sys.meta_path.append(EditableFinder)
"""


@EACH
def test_an_editable_install_through_a_finder(source: Path, tmp_path: Path, program: str) -> None:
    assert output_of(EDITABLE + program, str(source), cwd=tmp_path) == SHOWN


def test_modules_that_python_does_not_lead_to_are_not_run_but_explained(source: Path, tmp_path: Path) -> None:
    (source / 'my_robot' / '__init__.py').write_text('raise SystemExit("run")')
    program = 'from my_robot.msg import Joint\nprint(Joint())\nfrom my_robot.helper import f'
    done = run_python(program, cwd=tmp_path)
    assert done.stdout == 'my_robot.msg.Joint(angle=0.0)\n'
    assert f'pip install -e {source}, or add {source} to PYTHONPATH' in done.stderr
    assert "ModuleNotFoundError: No module named 'my_robot.helper'" in done.stderr


def test_what_rosidl_generated_wins(source: Path, tmp_path: Path) -> None:
    write_files(source, {'my_robot/msg/__init__.py': 'Joint = "theirs"'})
    shown = output_of('from my_robot.msg import Joint; import my_robot.srv; print(Joint)', cwd=source)
    assert shown == 'theirs'


@pytest.mark.parametrize('module', ['json.msg', 'email.action', 'my_plain.msg', 'my_plain.srv'])
def test_other_packages_have_no_interfaces(tmp_path: Path, module: str) -> None:
    write_files(tmp_path, {'my_plain/__init__.py': '', f'my_plain{os.sep}srv.py': 'x = 1'})
    program = f'import importlib.util; print(importlib.util.find_spec({module!r}) is not None)'
    assert output_of(program, cwd=tmp_path) == str(module == 'my_plain.srv')
