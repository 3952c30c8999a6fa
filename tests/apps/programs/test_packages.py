"""Packages that tutorials and launch files name: their programs are found, and each has its function."""

from __future__ import annotations

import configparser
from importlib import import_module
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_share_directory

import goalwire
from goalwire.launching.packages import executables
from goalwire.launching.source_programs import console_scripts

SHARE = Path(goalwire.__file__).parent / 'prefix' / 'share'
PACKAGES = sorted(file.parent.name for file in SHARE.glob('*/setup.cfg'))


@pytest.mark.parametrize('package', PACKAGES)
def test_every_program_that_a_package_names_has_its_function(package: str) -> None:
    scripts = console_scripts(str(SHARE / package))
    assert scripts
    for module, function in scripts.values():
        assert callable(getattr(import_module(module), function))


@pytest.mark.parametrize('package', PACKAGES)
def test_ros2_run_finds_the_programs(package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    found = [Path(path).name for path in executables(package)]
    assert found == sorted(console_scripts(get_package_share_directory(package)))


def test_setup_files_have_no_name_twice() -> None:
    for package in PACKAGES:
        parser = configparser.ConfigParser(interpolation=None)
        parser.read_string((SHARE / package / 'setup.cfg').read_text(encoding='utf-8'))
        lines = parser['options.entry_points']['console_scripts'].split('\n')
        names = [line.partition('=')[0].strip() for line in lines if line]
        assert len(names) == len(set(names)), package
