"""Python programs, pip too, start in a folder with any files below it, and say what is bad."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.fresh import clean_environment, run_python
from helpers.packages import write_files, write_package

from goalwire import files
from goalwire.idl import workspace

Make = Callable[[Path], object]

FOO = {'msg/Foo.msg': 'int32 x\n'}
held_groups = '<package><name>held_msgs</name></package>'
# Any program: a module that is there, one that is not (so goalwire looks for it), interfaces beside the bad.
PROGRAM = """\
    import wave
    try:
        import try_nothing
    except ModuleNotFoundError as error:
        print(error)
    from good_msgs.msg import Foo
    print(Foo())
"""
SAID = ["No module named 'try_nothing'", 'good_msgs.msg.Foo(x=0)']

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='pipes and devices have no names there')


def encoded(encoding: str, codec: str = 'ascii') -> Make:
    text = f'<?xml version="1.0" encoding="{encoding}"?>{held_groups}'
    return lambda path: path.write_bytes(text.encode(codec))


def holding(data: bytes) -> Make:
    return lambda path: path.write_bytes(data)


def named(name: str) -> Make:
    return holding(f'<package><name>{name}</name></package>'.encode())


def linked(target: str) -> Make:
    return lambda path: path.symlink_to(target)


def huge(path: Path) -> None:
    with path.open('wb') as file:
        file.truncate(3 * 2**30)  # sparse


def bound_socket(path: Path) -> None:
    here = Path.cwd()
    os.chdir(path.parent)  # the name of a socket is short
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(path.name)
    os.chdir(here)


def linked_pipe(path: Path) -> None:
    os.mkfifo(path.with_name('pipe'))
    path.symlink_to('pipe')


UNREADABLE = (
    *('gb2312', 'gbk', 'gb18030', 'shift_jis', 'euc-jp', 'euc-kr', 'big5', 'utf-7', 'utf-32'),
    *('hex', 'zlib', 'rot13', 'idna', 'punycode', 'undefined', 'no-such-encoding', 'x' * 9000),
)
LAUGHS = ''.join(f'<!ENTITY a{n + 1} "{f"&a{n};" * 10}">' for n in range(12))
SPECIAL: dict[str, Make] = {
    'pipe': os.mkfifo,
    'link to a pipe': linked_pipe,
    'socket': bound_socket,
    'folder': Path.mkdir,
    'link to itself': linked('package.xml'),
    'link to nothing': linked('nothing'),
    'endless device': linked('/dev/zero'),
    'full device': linked('/dev/full'),
    'random device': linked('/dev/urandom'),
    'the terminal': linked('/dev/tty'),
    '3 GB': huge,
}
CONTENT: dict[str, Make] = {
    **{name: encoded(name) for name in UNREADABLE},
    'utf-32 in earnest': encoded('utf-32', 'utf-32'),
    'utf-32 without a mark': encoded('utf-32', 'utf-32-le'),
    'no UTF-8': holding(b'<?xml version="1.0" encoding="utf-8"?><package><name>\xe4</name></package>'),
    'empty': holding(b''),
    'zeros': holding(bytes(5000)),
    'noise': holding(bytes(range(256)) * 20),
    'no XML': holding(b'name: held_msgs\n'),
    'cut off': holding(held_groups[:-5].encode()),
    'two roots': holding(held_groups.encode() * 2),
    'no name': holding(b'<package/>'),
    'laughs': holding(
        f'<!DOCTYPE p [<!ENTITY a0 "ha">{LAUGHS}]><package><name>&a12;</name></package>'.encode()
    ),
    'entity of a device': holding(
        b'<!DOCTYPE p [<!ENTITY z SYSTEM "file:///dev/zero">]><package><name>&z;</name></package>'
    ),
    'deep': holding(b'<a>' * 300_000),
    'name that is a path': named('../../etc'),
    'name with a line': named('a\nb'),
    'name of another alphabet': named('r\u00f6bot'),
    'name with a terminal in it': named('\x9b31m'),
    'half a character': named('&#xD800;'),
    'long name': named('n' * 900_000 + '-'),
}


@pytest.mark.parametrize('bad', [*SPECIAL, *CONTENT])
def test_a_bad_package_xml_is_one_warning_and_programs_go_on(bad: str, tmp_path: Path) -> None:
    write_package(tmp_path / 'good', 'good_msgs', FOO)
    write_files(tmp_path / 'bad', FOO)
    manifest = tmp_path / 'bad' / 'package.xml'
    (SPECIAL | CONTENT)[bad](manifest)
    done = run_python(PROGRAM, cwd=tmp_path)
    assert (done.returncode, done.stdout.splitlines()) == (0, SAID), done.stderr
    assert done.stderr.count('RuntimeWarning') == 1
    assert str(manifest) in done.stderr
    assert len(done.stderr) < 10_000 + 2 * len(str(tmp_path))
    assert '\x9b' not in done.stderr


@pytest.fixture(scope='module')
def everything_bad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all of them, one of each kind of definition, and installed packages like them."""
    root = tmp_path_factory.mktemp('bad')
    write_package(root / 'good', 'good_msgs', FOO)
    for number, make in enumerate((SPECIAL | CONTENT).values()):
        write_files(root / f'bad{number}', FOO)
        make(root / f'bad{number}' / 'package.xml')
        (root / f'bad{number}.dist-info').mkdir()
        make(root / f'bad{number}.dist-info' / 'entry_points.txt')
        write_package(root / f'defs{number}', f'defs{number}_msgs', FOO)
        make(root / f'defs{number}' / 'msg' / 'Bad.msg')
    return root


@pytest.mark.parametrize('options', [(), ('-W', 'ignore'), ('-W', 'error')], ids=' '.join)
def test_programs_run_amid_all_of_it(everything_bad: Path, options: tuple[str, ...]) -> None:
    done = run_python(
        'try:\n    import try_nothing\nexcept ImportError:\n    print("missed")',
        cwd=everything_bad,
        options=options,
    )
    assert (done.returncode, done.stdout) == (0, 'missed\n'), done.stderr


@pytest.mark.slow
def test_pip_runs_amid_all_of_it(everything_bad: Path) -> None:
    done = subprocess.run(
        [sys.executable, '-m', 'pip', '--version'],
        cwd=everything_bad, env=clean_environment(), capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith('pip ')


# A text is read as UTF-8, whatever it holds, so what XML forbids may be a good definition or one that breaks
# the grammar. Special files are never one.
@pytest.mark.parametrize('kind', ['msg', 'srv', 'action'])
@pytest.mark.parametrize('bad', SPECIAL)
def test_a_bad_definition_is_an_error_that_names_it_and_the_others_work(
    bad: str, kind: str, tmp_path: Path
) -> None:
    package = write_package(
        tmp_path / 'p', 'good_msgs', FOO | {f'{kind}/Other.{kind}': '---\n' * 'msa'.index(kind[0])}
    )
    SPECIAL[bad](package / kind / f'Bad.{kind}')
    program = f"""\
        try:
            from good_msgs.{kind} import Bad
        except ImportError as error:
            print(type(error).__name__, error)
        from good_msgs.{kind} import Other
    """
    done = run_python(program, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.startswith(f'InterfaceError {package / kind / f"Bad.{kind}"}: cannot be read: ')


def test_definitions_in_other_encodings_are_refused_with_file_and_line(tmp_path: Path) -> None:
    package = write_package(tmp_path / 'p', 'good_msgs', FOO)
    for codec in ('utf-16', 'utf-32', 'gb2312', 'shift_jis', 'latin-1', 'cp1252'):
        text = 'int32 x\n# ' + ('\u4e2d\u6587' if codec in {'gb2312', 'shift_jis'} else 'w\u00e4rme') + '\n'
        (package / 'msg' / f'In{codec.replace("-", "").replace("_", "").title()}.msg').write_bytes(
            text.encode(codec)
        )
    program = """\
        import good_msgs.msg
        for name in good_msgs.msg.__all__:
            try:
                getattr(good_msgs.msg, name)
            except ImportError as error:
                print(error)
    """
    done = run_python(program, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.count('not UTF-8 text') == 6
    assert f'{package / "msg" / "InGb2312.msg"}:2:1' in done.stdout


def test_definitions_are_read_only_up_to_a_bound(tmp_path: Path) -> None:
    package = write_package(tmp_path / 'p', 'good_msgs', FOO)
    (package / 'msg' / 'Long.msg').write_bytes(b'# comment\n' * (files.LARGEST_DEFINITION // 10 + 1))
    done = run_python('from good_msgs.msg import Long', cwd=tmp_path)
    assert 'Long.msg: cannot be read: it has more than 1,048,576 bytes' in done.stderr


def test_the_walk_passes_over_marks_and_folders_that_are_none(tmp_path: Path) -> None:
    write_package(tmp_path / 'good', 'good_msgs', FOO)
    write_package(tmp_path / 'hidden', 'hidden_msgs', FOO)
    os.mkfifo(tmp_path / 'hidden' / 'COLCON_IGNORE')
    for name in ('msg', 'srv', 'action'):
        write_package(tmp_path / f'p{name}', f'p_{name}', {})
        os.mkfifo(tmp_path / f'p{name}' / name)
    ring = tmp_path / 'ring'
    ring.symlink_to(ring)
    for number in range(20):
        (tmp_path / f'again{number}').symlink_to(tmp_path)
    os.mkdir(os.fsencode(tmp_path) + b'/\xff\x1b[31m')  # noqa: PTH102  # no text
    write_files(tmp_path / '\udcff\x1b[31m', FOO | {'package.xml': ''})
    done = run_python(PROGRAM, cwd=tmp_path)
    assert (done.returncode, done.stdout.splitlines()) == (0, SAID), done.stderr
    assert '\x1b' not in done.stderr
    assert done.stderr.count('RuntimeWarning') == 1


@pytest.mark.skipif(not hasattr(os, 'geteuid') or os.geteuid() == 0, reason='root may read everything')
def test_what_may_not_be_read_is_passed_over_or_warned_of(tmp_path: Path) -> None:
    write_package(tmp_path / 'good', 'good_msgs', FOO)
    manifest = write_package(tmp_path / 'closed', 'closed_msgs', FOO) / 'package.xml'
    manifest.chmod(0)
    (tmp_path / 'folder').mkdir(mode=0)
    done = run_python(PROGRAM, cwd=tmp_path)
    assert (done.returncode, done.stdout.splitlines()) == (0, SAID)
    assert f'{manifest} cannot be read: Permission denied' in done.stderr


def test_a_file_that_vanishes_meanwhile_is_remarked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = write_package(tmp_path / 'p', 'p_msgs', FOO)

    def read(path: str, largest: int) -> bytes:
        (package / 'package.xml').unlink(missing_ok=True)
        return files.read_regular(path, largest)

    monkeypatch.setattr(workspace, 'read_regular', read)
    assert workspace.scan(str(tmp_path)).unusable == [
        f'{package / "package.xml"} cannot be read: No such file or directory'
    ]


def test_the_walk_looks_at_so_many_names_and_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workspace, 'ENTRIES', 50)
    write_files(tmp_path / 'a', {f'{number}.png': '' for number in range(60)})
    write_package(tmp_path / 'z', 'late_msgs', FOO)
    found = workspace.scan(str(tmp_path))
    assert (found.packages, found.complete) == ({}, False)
    assert found.remarks == [f'the search below {tmp_path} ended after 50 files']


def test_python_s_path_may_hold_anything(tmp_path: Path) -> None:
    program = """\
        import sys
        from pathlib import Path
        sys.path[:0] = [b'x', Path('y'), None, 3, [], '/dev/zero', 'package.xml']
        try:
            import try_nothing
        except ModuleNotFoundError as error:
            print(error)
        from std_msgs.msg import String
    """
    done = run_python(program, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "No module named 'try_nothing'\n", '')


def test_registrations_that_lead_in_a_circle_end(tmp_path: Path) -> None:
    entries = ('a_msgs = b_msgs', 'b_msgs = a_msgs', 'c_msgs = c_msgs', 'd_msgs = ..x', 'e_msgs = x:y')
    text = '\n'.join(('[goalwire.interfaces]', *entries))
    write_files(tmp_path, {'a-1.dist-info/entry_points.txt': text})
    program = """\
        import importlib.util
        print([name for name in 'abcde' if importlib.util.find_spec(f'{name}_msgs')])
    """
    done = run_python(program, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, '[]\n'), done.stderr
    assert done.stderr.count('leads to no folder') == 5


def test_a_fault_of_the_search_itself_is_a_warning(tmp_path: Path) -> None:
    program = """\
        from goalwire.idl import search_path
        search_path.find_package = lambda name, **_: 1 / 0
        try:
            import try_nothing
        except ModuleNotFoundError as error:
            print(error)
    """
    done = run_python(program, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "No module named 'try_nothing'\n")
    assert "cannot look for interfaces of 'try_nothing': ZeroDivisionError" in done.stderr
