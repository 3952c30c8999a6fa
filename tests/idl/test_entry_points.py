from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.packages import write_files

from goalwire.idl import entry_points


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder at the front of sys.path, on which nothing else is installed (the robot may be)."""
    installed = ('site-packages', 'humanoid')
    monkeypatch.syspath_prepend(tmp_path)  # its end puts the whole path back
    sys.path[:] = [entry for entry in sys.path if not Path(entry).name.startswith(installed)]
    entry_points.discard()
    yield tmp_path
    entry_points.discard()


def test_only_the_group_of_goalwire_is_read(site: Path) -> None:
    entries = '[console_scripts]\ntool = a:main\n[goalwire.interfaces]\n# note\nmy_msgs = my.definitions\n'
    write_files(site, {'a-1.dist-info/entry_points.txt': entries})
    assert entry_points.registrations() == {'my_msgs': 'my.definitions'}


def test_distributions_without_entry_points_and_broken_entries_of_the_path_are_passed_over(
    site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_files(
        site, {'a-1.dist-info/METADATA': 'Name: a\n', 'b-1.dist-info/entry_points.txt': '[other]\nx = y\n'}
    )
    monkeypatch.syspath_prepend(site / 'missing.zip')
    assert entry_points.registrations() == {}


def test_the_first_in_the_path_wins(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder, value in (('late', 'late_one'), ('early', 'early_one')):
        text = f'[goalwire.interfaces]\nmy_msgs = {value}\n'
        write_files(site / folder, {'a-1.dist-info/entry_points.txt': text})
        monkeypatch.syspath_prepend(site / folder)
    assert entry_points.registrations() == {'my_msgs': 'early_one'}


def test_the_folder_of_a_registered_package_is_found_without_running_it(site: Path) -> None:
    write_files(site, {'defs/__init__.py': 'raise SystemExit("imported")'})
    assert entry_points.folder_of('defs') == str(site / 'defs')


@pytest.mark.parametrize('value', ['no_such_module', 'no_such.module', 'json.decoder'])
def test_what_is_no_package_has_no_folder(site: Path, value: str) -> None:
    assert entry_points.folder_of(value) is None
