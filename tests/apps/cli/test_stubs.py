"""goalwire stubs: packages of one's own are typed in every checker, without a setting."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from helpers.command_line import CommandLine
from helpers.isolation import isolated_env
from helpers.packages import write_package

LAMP = {'msg/Light.msg': 'float64 brightness\n', 'msg/Broken.msg': 'int33 x\n'}


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """The site-packages of an environment that is active."""
    folder = tmp_path / 'venv' / 'lib' / 'python3.x' / 'site-packages'
    folder.mkdir(parents=True)
    return folder


@pytest.fixture
def goalwire(tmp_path: Path, site: Path) -> CommandLine:
    """`goalwire` in a workspace with lamp_interfaces."""
    write_package(tmp_path / 'ws' / 'src' / 'lamp_interfaces', 'lamp_interfaces', LAMP)
    environment = isolated_env('rmw_zenoh_cpp') | {'VIRTUAL_ENV': str(tmp_path / 'venv')}
    return CommandLine(environment, tmp_path / 'ws')


def written(site: Path) -> set[str]:
    return {file.relative_to(site).as_posix() for file in site.rglob('*.pyi')}


def test_stubs_go_into_the_active_environment_and_a_broken_file_is_passed_over(
    goalwire: CommandLine, site: Path
) -> None:
    ended = goalwire('stubs', 'lamp_interfaces', program='goalwire')
    assert written(site) == {'lamp_interfaces-stubs/__init__.pyi', 'lamp_interfaces-stubs/msg/__init__.pyi'}
    assert ended.code == 1
    assert ended.lines[0].startswith('passed over: ')
    assert ended.lines[0].endswith("Broken.msg:1:1: 'int33' is not a type; did you mean int32?")
    assert ended.lines[1] == f'2 files in {site}, for: lamp_interfaces'
    text = (site / 'lamp_interfaces-stubs' / 'msg' / '__init__.pyi').read_text(encoding='utf-8')
    assert 'class Light:' in text
    assert 'Broken' not in text


def test_without_a_name_all_packages_of_the_workspace_are_written(
    goalwire: CommandLine, site: Path, tmp_path: Path
) -> None:
    write_package(tmp_path / 'ws' / 'other', 'other_msgs', {'msg/A.msg': ''})
    found = goalwire('stubs', '--json', program='goalwire')
    told = json.loads(found.out)
    assert {'lamp_interfaces', 'other_msgs'} <= set(told['packages'])
    assert 'other_msgs-stubs/msg/__init__.pyi' in written(site)


def test_another_folder_can_be_named(goalwire: CommandLine, tmp_path: Path) -> None:
    goalwire('stubs', 'lamp_interfaces', '--directory', 'typings', program='goalwire')
    assert (tmp_path / 'ws' / 'typings' / 'lamp_interfaces-stubs' / 'msg' / '__init__.pyi').exists()


def test_a_missing_package_is_told(goalwire: CommandLine) -> None:
    assert 'lump_interfaces' in goalwire.fails('stubs', 'lump_interfaces', code=3)


@pytest.mark.skipif(not hasattr(os, 'geteuid') or os.geteuid() == 0, reason='root may write everywhere')
def test_a_folder_that_cannot_be_written_is_told(goalwire: CommandLine, site: Path) -> None:
    site.chmod(0o500)
    assert 'cannot write to' in goalwire.fails('stubs', 'lamp_interfaces', code=1)


def test_a_new_package_of_interfaces_is_typed_at_once(goalwire: CommandLine, site: Path) -> None:
    out = goalwire.ok('new', 'my_lamp', '--interfaces', program='goalwire')
    assert f'2 files in {site}, for: my_lamp_interfaces' in out
    assert 'my_lamp_interfaces-stubs/msg/__init__.pyi' in written(site)
