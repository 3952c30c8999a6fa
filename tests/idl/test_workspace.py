from __future__ import annotations

import sys
from pathlib import Path

import pytest
from helpers.packages import write_package

from goalwire.idl import workspace

FOO = {'msg/Foo.msg': 'int32 x\n'}


def names(root: Path) -> list[str]:
    return sorted(workspace.scan(str(root)).packages)


def test_the_root_itself_may_be_the_package(tmp_path: Path) -> None:
    write_package(tmp_path, 'here_msgs', FOO)
    assert names(tmp_path) == ['here_msgs']


def test_a_package_is_found_four_levels_down_and_not_five(tmp_path: Path) -> None:
    write_package(tmp_path / 'a/b/c/four', 'four_msgs', FOO)
    write_package(tmp_path / 'a/b/c/d/five', 'five_msgs', FOO)
    assert names(tmp_path) == ['four_msgs']


def test_the_name_is_that_of_package_xml_and_not_the_folders(tmp_path: Path) -> None:
    write_package(tmp_path / 'checkout-1.2', 'real_msgs', FOO)
    assert names(tmp_path) == ['real_msgs']


@pytest.mark.parametrize('mark', ['COLCON_IGNORE', 'AMENT_IGNORE', 'pyvenv.cfg'])
def test_a_marked_folder_is_passed_over_with_all_below_it(tmp_path: Path, mark: str) -> None:
    write_package(tmp_path / 'hidden/deeper', 'deeper_msgs', FOO)
    (tmp_path / 'hidden' / mark).touch()
    write_package(tmp_path / 'seen', 'seen_msgs', FOO)
    assert names(tmp_path) == ['seen_msgs']


@pytest.mark.parametrize('folder', ['.git', '.venv', 'build', 'install', 'log', 'node_modules'])
def test_results_of_builds_and_hidden_folders_are_passed_over(tmp_path: Path, folder: str) -> None:
    write_package(tmp_path / folder / 'copy', 'copy_msgs', FOO)
    assert names(tmp_path) == []


def test_a_package_without_definitions_is_none_and_is_not_looked_into(tmp_path: Path) -> None:
    write_package(tmp_path / 'nodes', 'nodes', {'nodes/main.py': ''})
    write_package(tmp_path / 'nodes' / 'inner', 'inner_msgs', FOO)
    assert names(tmp_path) == []


def test_a_comment_in_package_xml_is_no_name(tmp_path: Path) -> None:
    manifest = '<package><!-- <name>old_msgs</name> --><name> new_msgs\n</name></package>'
    write_package(tmp_path / 'p', 'unused', FOO, manifest=manifest)
    assert names(tmp_path) == ['new_msgs']


@pytest.mark.parametrize(
    ('manifest', 'said'),
    [('<package><name>x</name>', 'not well-formed'), ('<package/>', 'no <name>'), ('', 'not well-formed')],
)
def test_a_broken_package_xml_is_remarked_with_its_file(tmp_path: Path, manifest: str, said: str) -> None:
    write_package(tmp_path / 'p', 'unused', FOO, manifest=manifest)
    found = workspace.scan(str(tmp_path))
    assert found.packages == {}
    assert len(found.remarks) == 1
    assert str(tmp_path / 'p' / 'package.xml') in found.remarks[0]
    assert said in found.remarks[0]


def test_of_two_packages_of_one_name_the_nearer_is_used_and_the_other_remarked(tmp_path: Path) -> None:
    far = write_package(tmp_path / 'a/b', 'twin_msgs', FOO)
    near = write_package(tmp_path / 'z', 'twin_msgs', {'msg/Other.msg': 'int32 y\n'})
    found = workspace.scan(str(tmp_path))
    assert found.packages == {'twin_msgs': str(near)}
    assert str(far) in found.remarks[0]
    assert 'COLCON_IGNORE' in found.remarks[0]


def test_the_walk_ends_after_so_many_folders_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workspace, 'FOLDERS', 5)
    for n in range(10):
        (tmp_path / str(n)).mkdir()
    write_package(tmp_path / 'z', 'late_msgs', FOO)
    found = workspace.scan(str(tmp_path))
    assert not found.complete
    assert found.packages == {}
    assert 'ended after 5 folders' in found.remarks[0]


def test_a_ring_of_links_ends(tmp_path: Path) -> None:
    (tmp_path / 'a').mkdir()
    (tmp_path / 'a' / 'again').symlink_to(tmp_path)
    write_package(tmp_path / 'p', 'p_msgs', FOO)
    assert names(tmp_path) == ['p_msgs']


@pytest.mark.skipif(sys.platform != 'linux', reason='/proc is what holds links that may not be followed')
def test_what_may_not_be_read_is_passed_over() -> None:
    assert workspace.scan('/proc').packages == {}


def test_other_files_beside_definitions_are_not_definitions(tmp_path: Path) -> None:
    files = {'msg/Foo.msg': '', 'msg/Foo.idl': '', 'msg/.Hidden.msg': '', 'msg/CMakeLists.txt': ''}
    package = write_package(tmp_path, 'p_msgs', files)
    assert workspace.definition_names(str(package), 'msg') == ['Foo']
