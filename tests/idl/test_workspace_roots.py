"""The working directory of an installed command may be anybody's: /tmp, a shared folder, a download."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.command_line import CommandLine, executable
from helpers.fresh import clean_environment, output_of, run_python
from helpers.packages import write_files, write_package

from goalwire.files import why_others_write
from goalwire.idl import workspace

FOO = {'msg/Foo.msg': 'int32 x\n'}
SHOW = ('interface', 'show', 'foo_msgs/msg/Foo')
pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='modes and owners of POSIX')
by_root = pytest.mark.skipif(sys.platform == 'win32' or os.geteuid() != 0, reason='only root gives away')


@pytest.fixture
def ros2(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CommandLine:
    """The installed command, in an empty folder of this user."""
    here = tmp_path / 'here'
    here.mkdir()
    monkeypatch.chdir(here)
    return CommandLine(clean_environment(XDG_CACHE_HOME=str(tmp_path / 'cache')))


def refused(root: Path) -> list[str]:
    found = workspace.scan(str(root), guarded=True)
    assert found.packages == {}
    assert found.manifests == []
    return found.refused


def test_a_folder_below_the_working_directory_does_not_replace_a_shipped_package(ros2: CommandLine) -> None:
    write_package(Path('x/std_msgs').absolute(), 'std_msgs', FOO)
    done = ros2('interface', 'show', 'std_msgs/msg/String')
    assert 'string data' in done.out
    assert done.err == ''
    there = str(Path('x').absolute())
    assert ros2('interface', 'show', 'std_msgs/msg/Foo', GOALWIRE_INTERFACE_PATH=there).out == 'int32 x\n'


def test_a_command_says_in_one_line_which_package_it_takes_from_the_working_directory(
    ros2: CommandLine,
) -> None:
    folder = write_package(
        Path('src/foo').absolute(), 'foo_msgs', {'msg/Foo.msg': 'Bar b\n', 'msg/Bar.msg': 'int8 y\n'}
    )
    done = ros2('interface', 'show', '--all-comments', 'foo_msgs/msg/Foo')
    assert done.out == 'Bar b\n\tint8 y\n'
    assert done.err == f'note: the package foo_msgs is taken from {folder}, below the working directory\n'
    assert ros2(*SHOW, GOALWIRE_INTERFACE_PATH=str(folder)).err == ''
    assert ros2('interface', 'list').err == ros2('pkg', 'list').err == ''  # nothing is used


def test_a_command_takes_nothing_from_a_folder_that_others_write_to_and_says_so(ros2: CommandLine) -> None:
    write_package(Path('src/foo').absolute(), 'foo_msgs', FOO)
    Path('src').chmod(0o777)
    done = ros2(*SHOW)
    assert done.code == 3
    assert done.out == ''
    assert f'{Path("src").absolute()} is not searched, because everybody may write to it' in done.err
    assert 'foo_msgs' not in ros2('pkg', 'list').out
    assert 'not searched, because everybody may write to it' in ros2('run', 'foo_msgs', 'prog').err


def test_a_program_of_a_source_package_is_run_with_a_line_and_never_from_a_folder_of_others(
    ros2: CommandLine,
) -> None:
    files = {'setup.cfg': '[options.entry_points]\nconsole_scripts =\n    go = a:go\n', 'a.py': ''}
    folder = write_package(Path('src/foo').absolute(), 'foo', files)
    write_files(folder, {'a.py': 'def go():\n    print("gone")\n'})
    done = ros2('run', 'foo', 'go')
    assert done.out == 'gone\n'
    assert done.err == f'note: the package foo is taken from {folder}, below the working directory\n'
    Path('src').chmod(0o1777)
    done = ros2('run', 'foo', 'go')
    assert done.out == ''
    assert "package 'foo' not found" in done.err
    assert 'everybody may write to it' in done.err


def test_a_source_package_adds_no_programs_to_an_installed_one(ros2: CommandLine) -> None:
    files = {'setup.cfg': '[options.entry_points]\nconsole_scripts =\n    go = a:go\n', 'a.py': 'go = print'}
    write_package(Path('src/std_msgs').absolute(), 'std_msgs', {**files, **FOO})
    assert ros2('pkg', 'executables', 'std_msgs').out == ''
    assert ros2('run', 'std_msgs', 'go').code == 3


@pytest.mark.parametrize('mode', [0o777, 0o1777, 0o757])
@pytest.mark.parametrize('open_to_all', ['.', 'src', 'src/foo', 'src/foo/msg'])
def test_each_folder_on_the_way_to_a_definition_is_looked_at(
    tmp_path: Path, open_to_all: str, mode: int
) -> None:
    write_package(tmp_path / 'src' / 'foo', 'foo_msgs', FOO)
    assert 'foo_msgs' in workspace.scan(str(tmp_path), guarded=True).packages
    (tmp_path / open_to_all).chmod(mode)
    assert 'foo_msgs' in workspace.scan(str(tmp_path)).packages
    place = (tmp_path / open_to_all).resolve()
    assert refused(tmp_path) == [f'{place} is not searched, because everybody may write to it']


@pytest.mark.parametrize('link', ['src', 'src/foo', 'src/foo/msg'])
def test_a_link_counts_as_the_folder_that_it_leads_to(tmp_path: Path, link: str) -> None:
    root = tmp_path / 'root'
    write_package(root / 'src' / 'foo', 'foo_msgs', FOO)
    target = (root / link).rename(tmp_path / 'target')
    (root / link).symlink_to(target)
    assert 'foo_msgs' in workspace.scan(str(root), guarded=True).packages
    target.chmod(0o777)
    assert refused(root) == [f'{root / link} is not searched, because everybody may write to it']


@by_root
@pytest.mark.parametrize(
    ('uid', 'gid', 'mode', 'why'),
    [
        (0, 0, 0o775, ''),  # a group of root alone
        (65534, 0, 0o755, 'it belongs to another user'),
        (0, 65534, 0o775, 'its group may write to it'),
        (0, 65534, 0o755, ''),
    ],
)
def test_owner_and_group_count(tmp_path: Path, uid: int, gid: int, mode: int, why: str) -> None:
    folder = tmp_path / 'folder'
    folder.mkdir()
    os.chown(folder, uid, gid)
    folder.chmod(mode)
    assert why_others_write(folder.stat()) == why


IMPORT = 'from foo_msgs.msg import Foo\nprint(Foo())\n'
SHOWN = 'foo_msgs.msg.Foo(x=0)'


def test_python_trusts_the_folder_that_it_imports_from(tmp_path: Path) -> None:
    write_package(tmp_path / 'foo', 'foo_msgs', FOO)
    tmp_path.chmod(0o777)
    done = run_python(IMPORT, cwd=tmp_path)
    assert (done.stdout.strip(), done.stderr) == (SHOWN, '')
    tmp_path.chmod(0o700)


def run_program(cwd: Path, program: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, program],
        cwd=cwd, env=clean_environment(), capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip


def test_a_program_trusts_the_tree_that_it_lies_in(tmp_path: Path) -> None:
    write_files(tmp_path, {'nodes/prog.py': IMPORT})
    write_package(tmp_path / 'foo', 'foo_msgs', FOO)
    (tmp_path / 'foo').chmod(0o777)
    done = run_program(tmp_path, 'nodes/prog.py')
    assert (done.stdout.strip(), done.stderr) == (SHOWN, '')


def test_a_program_from_elsewhere_says_what_it_takes(tmp_path: Path) -> None:
    write_files(tmp_path, {'elsewhere/prog.py': IMPORT})
    folder = write_package(tmp_path / 'here' / 'foo', 'foo_msgs', FOO)
    done = run_program(tmp_path / 'here', '../elsewhere/prog.py')
    assert done.stdout.strip() == SHOWN
    assert done.stderr == f'note: the package foo_msgs is taken from {folder}, below the working directory\n'


def test_a_launch_file_finds_a_source_package_with_one_line(ros2: CommandLine) -> None:
    launch = '<launch><log message="$(find-pkg-share foo) $(find-pkg-share foo)"/></launch>'
    folder = write_package(Path('src/foo').absolute(), 'foo', {'launch/a.launch.xml': launch})
    done = ros2('launch', 'foo', 'a.launch.xml')
    assert f'{folder} {folder}' in done.out + done.err
    assert done.err.count('is taken from') == 1


def test_listing_packages_from_a_folder_of_others_shows_the_shipped_ones(ros2: CommandLine) -> None:
    Path().absolute().chmod(0o777)
    write_package(Path('src/foo').absolute(), 'foo_msgs', FOO)
    names = ros2('pkg', 'list').out.split()
    assert 'std_msgs' in names
    assert 'foo_msgs' not in names
    assert executable().is_file()
    assert output_of('import std_msgs.msg', cwd=Path.cwd()) == ''
