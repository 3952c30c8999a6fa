from __future__ import annotations

import importlib
import os
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.fresh import clean_environment, run_python
from helpers.packages import write_files, write_package

from goalwire.errors import UnknownInterfaceError
from goalwire.idl import search_path, workspace
from goalwire.idl.search_path import explain_missing, find_package

FOO = {'msg/Foo.msg': 'int32 x\n'}


@pytest.fixture(autouse=True)
def empty_surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An empty working directory and no variables: only what a test adds is found."""
    here = tmp_path / 'here'
    here.mkdir()
    monkeypatch.chdir(here)
    monkeypatch.delenv(search_path.INTERFACE_PATH, raising=False)
    monkeypatch.delenv(search_path.PREFIX_PATH, raising=False)
    search_path.discard()
    yield
    search_path.discard()


def found_in(package: str) -> Path:
    found = find_package(package)
    assert found is not None
    return found.path


def register(site: Path, distribution: str, entries: str) -> None:
    """Lay out an installed distribution with entry points in a folder of sys.path."""
    metadata = f'Metadata-Version: 2.1\nName: {distribution}\nVersion: 1\n'
    write_files(
        site / f'{distribution}-1.dist-info',
        {'METADATA': metadata, 'entry_points.txt': f'[goalwire.interfaces]\n{entries}\n'},
    )


def test_an_entry_of_the_interface_path_may_be_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = write_files(tmp_path / 'foo_msgs', FOO)
    monkeypatch.setenv(search_path.INTERFACE_PATH, str(package) + os.sep)
    assert found_in('foo_msgs') == package


def test_an_entry_of_the_interface_path_may_have_another_name_than_its_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = write_package(tmp_path / 'checkout-1.2', 'foo_msgs', FOO)
    monkeypatch.setenv(search_path.INTERFACE_PATH, str(package))
    assert found_in('foo_msgs') == package
    assert 'foo_msgs' in search_path.package_names()


def test_an_entry_of_the_interface_path_may_hold_packages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = write_files(tmp_path / 'all' / 'foo_msgs', FOO)
    path = os.pathsep.join([str(tmp_path / 'missing'), str(tmp_path / 'all')])
    monkeypatch.setenv(search_path.INTERFACE_PATH, path)
    assert found_in('foo_msgs') == package


def test_an_ament_prefix_holds_definitions_in_share(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = write_files(tmp_path / 'prefix' / 'share' / 'foo_msgs', FOO)
    monkeypatch.setenv(search_path.PREFIX_PATH, str(tmp_path / 'prefix'))
    assert found_in('foo_msgs') == package


def test_an_installed_distribution_may_register_a_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = write_files(tmp_path / 'site' / 'foo_definitions', {'__init__.py': 'raise SystemExit', **FOO})
    register(tmp_path / 'site', 'foo', 'foo_msgs = foo_definitions')
    monkeypatch.syspath_prepend(tmp_path / 'site')
    assert found_in('foo_msgs') == module


def test_a_registration_that_leads_nowhere_is_warned_about(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    register(tmp_path / 'site', 'foo', 'foo_msgs = no_such_module')
    monkeypatch.syspath_prepend(tmp_path / 'site')
    with pytest.warns(RuntimeWarning, match='foo_msgs = no_such_module leads to no folder'):
        assert find_package('foo_msgs') is None


def test_the_working_directory_is_searched_downwards(tmp_path: Path) -> None:
    package = write_package(tmp_path / 'here' / 'src' / 'foo', 'foo_msgs', FOO)
    assert found_in('foo_msgs') == package


def test_a_second_package_of_one_name_below_the_working_directory_is_warned_about(tmp_path: Path) -> None:
    write_package(tmp_path / 'here' / 'a', 'twin_msgs', FOO)
    write_package(tmp_path / 'here' / 'b', 'twin_msgs', {'msg/Foo.msg': 'int32 y\n'})
    with pytest.warns(RuntimeWarning, match='second package named twin_msgs'):
        assert found_in('twin_msgs') == tmp_path / 'here' / 'a'


def test_a_copy_of_a_package_below_the_working_directory_is_not_warned_about(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    """Each exercise of the course has a copy of humanoid_interfaces."""
    write_package(tmp_path / 'here' / 'exercise_1', 'twin_msgs', FOO)
    write_package(tmp_path / 'here' / 'exercise_2', 'twin_msgs', FOO)
    assert found_in('twin_msgs') == tmp_path / 'here' / 'exercise_1'
    assert not recwarn.list


def run_program(program: Path, cwd: Path, *options: str) -> str:
    done = subprocess.run(
        [sys.executable, *options, os.path.relpath(program, cwd)],
        cwd=cwd, env=clean_environment(), capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


SHOW = 'from goalwire.idl.search_path import find_package\nprint(find_package("foo_msgs"))\n'


@pytest.mark.parametrize('options', [(), ('-P',), ('-I',), ('-m', 'goalwire.run')], ids=' '.join)
def test_the_programs_folder_is_searched_like_the_working_directory(
    tmp_path: Path, options: tuple[str, ...]
) -> None:
    write_files(tmp_path / 'robot' / 'nodes', {'prog.py': SHOW})
    package = write_package(tmp_path / 'robot' / 'nodes' / 'a' / 'b' / 'c' / 'foo', 'foo_msgs', FOO)
    shown = run_program(tmp_path / 'robot' / 'nodes' / 'prog.py', tmp_path / 'here', *options)
    assert shown == f"InterfacePackage('foo_msgs', {str(package)!r}, from the program's folder)"


def test_the_working_directory_comes_before_the_programs_folder(tmp_path: Path) -> None:
    write_files(tmp_path / 'robot', {'prog.py': SHOW})
    write_package(tmp_path / 'robot' / 'foo', 'foo_msgs', FOO)
    package = write_package(tmp_path / 'here' / 'foo', 'foo_msgs', FOO)
    assert str(package) in run_program(tmp_path / 'robot' / 'prog.py', tmp_path / 'here')


def test_processes_that_a_program_spawns_search_its_folder_too(tmp_path: Path) -> None:
    program = """\
        import multiprocessing
        from foo_msgs.msg import Foo
        def show():
            print(Foo.__name__)
        if __name__ == '__main__':
            process = multiprocessing.get_context('spawn').Process(target=show)
            process.start()
            process.join()
    """
    write_files(tmp_path / 'robot', {'prog.py': textwrap.dedent(program)})
    write_package(tmp_path / 'robot' / 'foo', 'foo_msgs', FOO)
    assert run_program(tmp_path / 'robot' / 'prog.py', tmp_path / 'here') == 'Foo'


def test_the_folder_of_an_installed_program_is_not_searched(tmp_path: Path) -> None:
    write_files(tmp_path / 'site-packages' / 'tool', {'prog.py': SHOW})
    write_package(tmp_path / 'site-packages' / 'tool' / 'foo', 'foo_msgs', FOO)
    assert run_program(tmp_path / 'site-packages' / 'tool' / 'prog.py', tmp_path / 'here') == 'None'


def test_the_order_is_interface_path_then_prefixes_then_registrations_then_shipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    by_path = write_files(tmp_path / 'path' / 'std_msgs', FOO)
    by_prefix = write_files(tmp_path / 'prefix' / 'share' / 'std_msgs', FOO)
    by_entry = write_files(tmp_path / 'site' / 'their_std', {'__init__.py': '', **FOO})
    write_package(tmp_path / 'here' / 'std_msgs', 'std_msgs', FOO)  # not named: never
    register(tmp_path / 'site', 'theirs', 'std_msgs = their_std')
    monkeypatch.setenv(search_path.INTERFACE_PATH, str(tmp_path / 'path'))
    monkeypatch.setenv(search_path.PREFIX_PATH, str(tmp_path / 'prefix'))
    with monkeypatch.context() as registered:
        registered.syspath_prepend(tmp_path / 'site')
        assert found_in('std_msgs') == by_path
        monkeypatch.delenv(search_path.INTERFACE_PATH)
        assert found_in('std_msgs') == by_prefix
        monkeypatch.delenv(search_path.PREFIX_PATH)
        assert found_in('std_msgs') == by_entry
    assert found_in('std_msgs') == Path(search_path.SHIPPED) / 'std_msgs'


def test_nothing_is_searched_below_the_working_directory_for_a_package_found_elsewhere(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    walked: list[str] = []

    def scan(root: str, **_: bool) -> workspace.Workspace:
        walked.append(root)
        return workspace.Workspace(root)

    monkeypatch.setattr(workspace, 'scan', scan)
    importlib.invalidate_caches()  # tests before this one may have searched for these
    assert found_in('std_msgs') == Path(search_path.SHIPPED) / 'std_msgs'
    assert walked == []
    assert find_package('foo_msgs') is None
    assert walked


def test_a_type_that_only_a_copy_of_a_shipped_package_has_is_explained(tmp_path: Path) -> None:
    copy = write_package(tmp_path / 'here' / 'std_msgs', 'std_msgs', FOO)
    done = run_python('from std_msgs.msg import Foo', cwd=tmp_path / 'here')
    assert f'{copy} is another: to use that one, name it in GOALWIRE_INTERFACE_PATH' in done.stderr


def test_an_answer_is_kept_until_caches_are_invalidated(tmp_path: Path) -> None:
    assert find_package('late_msgs') is None
    package = write_package(tmp_path / 'here' / 'late', 'late_msgs', FOO)
    assert find_package('late_msgs') is None
    importlib.invalidate_caches()
    assert found_in('late_msgs') == package


def test_a_folder_without_definitions_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / 'all' / 'std_msgs' / 'msg').mkdir(parents=True)
    monkeypatch.setenv(search_path.INTERFACE_PATH, str(tmp_path / 'all'))
    assert found_in('std_msgs') == Path(search_path.SHIPPED) / 'std_msgs'


def test_a_removed_working_directory_is_no_obstacle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gone = tmp_path / 'gone'
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    try:
        assert find_package('std_msgs') is not None
        assert find_package('foo_msgs') is None
    finally:
        os.chdir(tmp_path)


@pytest.mark.parametrize('name', ['', '../x', '/etc', 'Std_msgs', '_msgs', 'msgs_', 'a__b', 'a-b', '1a', 'ä'])
def test_a_name_that_no_package_can_have_is_refused(name: str) -> None:
    with pytest.raises(UnknownInterfaceError, match='is no ROS package name'):
        find_package(name)


def test_files_are_listed_by_kind_and_name(tmp_path: Path) -> None:
    files = {'srv/B.srv': '---', 'msg/Z.msg': '', 'msg/A.msg': '', 'action/C.action': '---\n---'}
    package = write_package(tmp_path / 'here' / 'foo', 'foo_msgs', files)
    found = find_package('foo_msgs')
    assert found is not None
    assert list(found.files().items()) == [
        ('msg/A', package / 'msg' / 'A.msg'),
        ('msg/Z', package / 'msg' / 'Z.msg'),
        ('srv/B', package / 'srv' / 'B.srv'),
        ('action/C', package / 'action' / 'C.action'),
    ]


def test_the_names_of_all_packages_come_from_every_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_files(tmp_path / 'path' / 'one_msgs', FOO)
    write_files(tmp_path / 'prefix' / 'share' / 'two_msgs', FOO)
    write_package(tmp_path / 'here' / 'three', 'three_msgs', FOO)
    monkeypatch.setenv(search_path.INTERFACE_PATH, str(tmp_path / 'path'))
    monkeypatch.setenv(search_path.PREFIX_PATH, str(tmp_path / 'prefix'))
    names = search_path.package_names()
    assert {'one_msgs', 'two_msgs', 'three_msgs', 'std_msgs'} <= set(names)
    assert names == sorted(names)


def test_whoever_misses_a_package_learns_where_was_looked_and_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    missing = tmp_path / 'missing'
    monkeypatch.setenv(search_path.INTERFACE_PATH, str(missing))
    write_package(tmp_path / 'here' / 'p', 'arm_interfaces', FOO)
    write_package(tmp_path / 'here' / 'broken', '', FOO, manifest='<package>')
    with pytest.warns(RuntimeWarning, match='not well-formed'):
        text = explain_missing('arms_interfaces')
    assert f'{missing} (no such folder)' in text
    assert 'AMENT_PREFIX_PATH: not set' in text
    assert f'{tmp_path / "here"}: arm_interfaces' in text
    assert 'not well-formed' in text
    assert 'Did you mean arm_interfaces' in text
    assert 'name its folder in GOALWIRE_INTERFACE_PATH' in text.splitlines()[0]
