"""Packages and resources of prefixes, and goalwire's own interface packages among them."""

from __future__ import annotations

import os
import sys
from importlib import invalidate_caches
from pathlib import Path

import ament_index_python as ament
import pytest
from helpers.packages import write_files, write_package

INDEX = 'share/ament_index/resource_index'


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


def test_a_package_of_the_source_tree_is_its_own_prefix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_package(tmp_path / 'src' / 'zoo', 'zoo_msgs', {'msg/Lion.msg': ''})
    monkeypatch.chdir(tmp_path)
    invalidate_caches()
    assert ament.get_package_share_directory('zoo_msgs') == str(folder)
    assert ament.get_package_prefix('zoo_msgs') == str(folder)


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
