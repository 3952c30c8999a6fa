"""Packages and resources of prefixes, and goalwire's own interface packages among them."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import invalidate_caches
from pathlib import Path

import ament_index_python as ament
import pytest
from helpers.packages import write_files, write_package

INDEX = 'share/ament_index/resource_index'


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where prefixes of links are made."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    return tmp_path / 'cache' / 'goalwire' / 'prefixes'


@pytest.fixture
def prefixes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    """Two prefixes in AMENT_PREFIX_PATH: both have `arm`, the first has `base`, the second `tool`."""
    one = write_files(
        tmp_path / 'one',
        {
            f'{INDEX}/packages/arm': '',
            f'{INDEX}/packages/base': '',
            f'{INDEX}/packages/.hidden': '',
            f'{INDEX}/plugins/base': 'wheels;legs',
            'share/arm/package.xml': '<package/>',
        },
    )
    two = write_files(
        tmp_path / 'two',
        {f'{INDEX}/packages/arm': '', f'{INDEX}/packages/tool': '', 'share/tool/config/a.yaml': ''},
    )
    set_prefixes(monkeypatch, one, tmp_path / 'missing', two)
    return one, two


def set_prefixes(monkeypatch: pytest.MonkeyPatch, *prefixes: Path) -> None:
    monkeypatch.setenv('AMENT_PREFIX_PATH', os.pathsep.join(map(str, prefixes)))
    monkeypatch.setattr(sys, 'prefix', '/nowhere')
    invalidate_caches()


def test_the_first_prefix_that_has_a_package_wins(prefixes: tuple[Path, Path]) -> None:
    one, two = map(str, prefixes)
    assert ament.get_package_prefix('arm') == one
    assert ament.get_package_prefix('tool') == two
    assert ament.get_package_share_directory('tool') == f'{two}/share/tool'
    assert (ament.get_package_share_path('tool') / 'config' / 'a.yaml').is_file()


def test_packages_are_listed_with_their_prefixes(prefixes: tuple[Path, Path]) -> None:
    one, two = map(str, prefixes)
    found = ament.get_packages_with_prefixes()
    assert {name: found[name] for name in ('arm', 'base', 'tool')} == {'arm': one, 'base': one, 'tool': two}
    assert '.hidden' not in found


def test_search_paths_are_the_prefixes_that_exist(prefixes: tuple[Path, Path]) -> None:
    assert ament.get_search_paths() == [str(prefix) for prefix in prefixes]


def test_what_pip_installed_is_found_in_pythons_own_prefix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_files(tmp_path, {f'{INDEX}/packages/camera': '', 'share/camera/package.xml': '<package/>'})
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    monkeypatch.setattr(sys, 'prefix', str(tmp_path))
    assert ament.get_search_paths() == [str(tmp_path)]
    assert ament.get_package_share_directory('camera') == str(tmp_path / 'share' / 'camera')


def test_without_any_prefix_there_are_the_interface_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    monkeypatch.setattr(sys, 'prefix', '/nowhere')
    assert ament.get_search_paths() == []
    share = Path(ament.get_package_share_directory('std_msgs'))
    assert (share / 'msg' / 'String.msg').is_file()
    assert Path(ament.get_package_prefix('std_msgs'), 'share', 'std_msgs') == share
    assert 'std_msgs' in ament.get_packages_with_prefixes()


def test_a_ros_2_that_has_an_interface_package_comes_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_files(tmp_path, {f'{INDEX}/packages/std_msgs': '', 'share/std_msgs/msg/String.msg': 'string data'})
    set_prefixes(monkeypatch, tmp_path)
    assert ament.get_package_prefix('std_msgs') == str(tmp_path)
    assert ament.get_packages_with_prefixes()['std_msgs'] == str(tmp_path)


def test_a_prefix_without_definition_files_comes_first_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_files(tmp_path, {f'{INDEX}/packages/std_msgs': ''})
    set_prefixes(monkeypatch, tmp_path)
    assert (
        ament.get_packages_with_prefixes()['std_msgs']
        == ament.get_package_prefix('std_msgs')
        == str(tmp_path)
    )


def executables(package: str) -> list[Path]:
    """List the programs below <prefix>/lib/<package>, as `ros2 run` and `ros2 pkg executables` find them."""
    files = Path(ament.get_package_prefix(package), 'lib', package).rglob('*')
    return sorted(file for file in files if os.access(file, os.X_OK))


@pytest.fixture
def zoo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The source folder of zoo_msgs, in the workspace that is the working directory."""
    folder = write_package(tmp_path / 'src' / 'zoo', 'zoo_msgs', {'msg/Lion.msg': ''})
    monkeypatch.chdir(tmp_path)
    invalidate_caches()
    return folder


def test_a_package_of_the_source_tree_has_a_prefix_around_it(zoo: Path, cache: Path) -> None:
    assert ament.get_package_share_directory('zoo_msgs') == str(zoo)
    assert not cache.exists()
    prefix = Path(ament.get_package_prefix('zoo_msgs'))
    assert prefix.parent == cache
    assert (prefix / 'share' / 'zoo_msgs').samefile(zoo)
    assert ament.get_packages_with_prefixes()['zoo_msgs'] == str(prefix)
    assert executables('zoo_msgs') == []


def test_every_package_that_is_listed_has_its_share_folder(zoo: Path) -> None:
    found = ament.get_packages_with_prefixes()
    assert {'zoo_msgs', 'std_msgs', 'composition_interfaces'} <= found.keys()
    assert [name for name, prefix in found.items() if not Path(prefix, 'share', name).is_dir()] == []


def test_links_that_were_lost_are_made_again(zoo: Path) -> None:
    prefix = Path(ament.get_package_prefix('zoo_msgs'))
    (prefix / 'share' / 'zoo_msgs').unlink()
    assert ament.get_package_prefix('zoo_msgs') == str(prefix)
    assert (prefix / 'share' / 'zoo_msgs' / 'msg' / 'Lion.msg').is_file()


def test_without_a_place_for_links_a_package_of_the_source_tree_is_its_own_prefix(
    zoo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'file').touch()
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file'))
    assert ament.get_package_prefix('zoo_msgs') == str(zoo)


@pytest.fixture
def pips(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Python's own prefix, into which pip installed the distribution Camera: package camera, two programs."""
    site = tmp_path / 'lib' / 'python' / 'site-packages'
    record = [
        f'../../../{INDEX}/packages/camera,sha256=x,0',
        '../../../bin/grab,sha256=x,9',
        '"../../../bin/view, all",sha256=x,9',
        '../../../bin/lost,sha256=x,9',
        'camera/bin/helper,sha256=x,9',
        'Camera-1.0.dist-info/RECORD,,',
    ]
    write_files(
        tmp_path,
        {
            f'{INDEX}/packages/camera': '',
            f'{INDEX}/plugins/camera': 'lens',
            'share/camera/package.xml': '<package/>',
            'bin/grab': '#!/bin/sh\necho grabbed\n',
            'bin/view, all': '#!/bin/sh\n',
            'bin/other': '#!/bin/sh\n',
        },
    )
    write_files(
        site / 'Camera-1.0.dist-info',
        {'METADATA': 'Name: Camera\nVersion: 1.0\n', 'RECORD': '\n'.join(record)},
    )
    for program in (tmp_path / 'bin').iterdir():
        program.chmod(0o755)
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    monkeypatch.setattr(sys, 'prefix', str(tmp_path))
    monkeypatch.syspath_prepend(str(site))
    return tmp_path


def test_programs_that_pip_installed_are_in_lib_as_ros2_run_looks_for_them(pips: Path) -> None:
    found = executables('camera')
    assert [file.name for file in found] == ['grab', 'view, all']
    assert found[0].samefile(pips / 'bin' / 'grab')
    assert subprocess.check_output([found[0]], text=True) == 'grabbed\n'


def test_a_package_has_no_programs_whose_module_is_another_package_beside_it(pips: Path) -> None:
    folder = pips / 'lib' / 'python' / 'site-packages' / 'Camera-1.0.dist-info'
    with (folder / 'RECORD').open('a', encoding='utf-8') as record:
        record.write(f'\n../../../{INDEX}/packages/camera_description,sha256=x,0')
    write_files(folder, {'entry_points.txt': '[console_scripts]\ngrab = camera.hand:main\n'})
    write_files(pips, {f'{INDEX}/packages/camera_description': '', 'share/camera_description/lens.urdf': ''})
    assert [file.name for file in executables('camera')] == ['grab', 'view, all']
    assert [file.name for file in executables('camera_description')] == ['view, all']


def test_the_share_folder_of_what_pip_installed_is_where_it_lies_and_in_the_prefix(pips: Path) -> None:
    share = pips / 'share' / 'camera'
    assert ament.get_package_share_directory('camera') == str(share)
    prefix = ament.get_package_prefix('camera')
    assert Path(prefix, 'share', 'camera').samefile(share)
    assert ament.has_resource('packages', 'camera') == prefix
    assert ament.get_packages_with_prefixes()['camera'] == prefix
    assert ament.get_resource('plugins', 'camera') == ('lens', str(pips))


def test_a_prefix_that_has_the_programs_in_lib_stays_the_prefix(pips: Path) -> None:
    write_files(pips / 'lib' / 'camera', {'grab': '#!/bin/sh\n'})
    assert ament.get_package_prefix('camera') == str(pips)


def test_an_unknown_package_is_an_error_that_says_where_was_looked(prefixes: tuple[Path, Path]) -> None:
    with pytest.raises(ament.PackageNotFoundError) as caught:
        ament.get_package_prefix('nope')
    assert isinstance(caught.value, KeyError)
    assert str(caught.value).startswith("package 'nope' not found, searching: [")
    assert str(prefixes[1]) in str(caught.value)


@pytest.mark.parametrize('name', ['', 'a', 'a b', '../a', '_a', 'ä1'])
def test_a_name_that_no_package_can_have_is_a_value_error(name: str) -> None:
    with pytest.raises(ValueError, match='is not a valid package name'):
        ament.get_package_share_directory(name)


def test_a_missing_share_folder_is_warned_about(prefixes: tuple[Path, Path]) -> None:
    with pytest.warns(UserWarning, match=r'Share directory for base \(.*\) does not exist') as caught:
        ament.get_package_share_directory('base')
    assert caught[0].filename == __file__
    assert ament.get_package_share_path('base', print_warning=False) == prefixes[0] / 'share' / 'base'


def test_a_resource_has_content_and_a_prefix(prefixes: tuple[Path, Path]) -> None:
    assert ament.get_resource('plugins', 'base') == ('wheels;legs', str(prefixes[0]))
    assert ament.has_resource('plugins', 'base') == str(prefixes[0])
    assert ament.get_resources('plugins') == {'base': str(prefixes[0])}
    assert {'packages', 'plugins'} <= ament.get_resource_types()


def test_an_interface_package_lists_its_definitions() -> None:
    content, _ = ament.get_resource('rosidl_interfaces', 'std_srvs')
    assert content.splitlines() == ['srv/Empty.srv', 'srv/SetBool.srv', 'srv/Trigger.srv']
    assert 'std_srvs' in ament.get_resources('rosidl_interfaces')


def test_a_missing_resource_is_a_lookup_error(prefixes: tuple[Path, Path]) -> None:
    assert ament.has_resource('plugins', 'arm') is False
    assert ament.has_resource('packages', 'nope') is False
    with pytest.raises(LookupError, match="Could not find the resource 'arm' of type 'plugins'"):
        ament.get_resource('plugins', 'arm')
    assert ament.get_resources('nothing') == {}


def test_names_with_slashes_are_refused() -> None:
    with pytest.raises(ament.InvalidResourceTypeNameError):
        ament.get_resources('a/b')
    with pytest.raises(ament.InvalidResourceTypeNameError):
        ament.has_resource('a\\b', 'c')
    with pytest.raises(ament.InvalidResourceNameError):
        ament.get_resource('a', 'b/c')
    with pytest.raises(AssertionError):
        ament.get_resource('a', '')
    with pytest.raises(AssertionError):
        ament.get_resources('')
