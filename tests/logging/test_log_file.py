"""The log file: its name, its lines, and what becomes of it."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest
from helpers.processes import Program

from goalwire import logging
from goalwire.logging import LoggingSeverity, LogRecord, configure, get_logger, release
from goalwire.logging.log_file import LogFile
from goalwire.logging.record import DEFAULT_FORMAT, compile_format

NO_FOLDER = '/dev/null/logs'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / 'not' / 'there' / 'yet'
    monkeypatch.setenv('ROS_LOG_DIR', str(path))
    return path


def lines(folder: Path) -> list[str]:
    (file,) = folder.iterdir()
    return file.read_text().splitlines()


def record(message: str) -> LogRecord:
    return LogRecord(1_500_000_000_000_000_001, LoggingSeverity.WARN, 'a.b', message, 'f', '/x.py', 7)


def test_lines_are_those_of_the_console_without_colours(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv('RCUTILS_COLORIZED_OUTPUT', '1')
    logging.clear_config()
    configure([], to_console=True, to_file=True)
    get_logger('a').warning('careful')
    printed = capsys.readouterr().err
    assert printed == f'\x1b[33m{lines(folder)[0]}\x1b[0m\n'


NAMED = [
    (['/home/me/lamp.py'], 'lamp'),
    (['./lamp.py', '--ros-args'], 'lamp'),
    (['/usr/bin/lamp'], 'lamp'),
    (['/site-packages/lamps/__main__.py'], 'lamps'),
    (['/tmp/a lamp\n\x1b[2J.py'], 'a_lamp___2J'),
    (['-c'], 'a.b'),
    (['-'], 'a.b'),
    ([''], 'a.b'),
    ([], 'a.b'),
]


@pytest.mark.parametrize(('argv', 'name'), NAMED)
def test_the_name_tells_program_process_and_time(
    folder: Path, monkeypatch: pytest.MonkeyPatch, argv: list[str], name: str
) -> None:
    monkeypatch.setattr(sys, 'argv', argv)
    configure([], to_console=False, to_file=True)
    get_logger('a.b').info('x')
    (file,) = folder.iterdir()
    program, pid, ms = file.stem.rsplit('_', 2)
    assert (program, pid) == (name, str(os.getpid()))
    assert len(ms) == 13
    assert file.suffix == '.log'


@pytest.mark.parametrize('exists', [True, False])
def test_a_link_that_has_the_files_name_is_not_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, exists: bool
) -> None:
    monkeypatch.setattr(time, 'time_ns', lambda: 1_500_000_000_000_000_000)
    folder, victim = tmp_path / 'logs', tmp_path / 'victim'
    folder.mkdir()
    if exists:
        victim.write_text('precious\n')
    link = folder / f'lamp_{os.getpid()}_1500000000000.log'
    link.symlink_to(victim)
    file = LogFile(str(folder), compile_format('{message}'), 'lamp')
    file(record('x'))
    file.close()
    assert (victim.read_text() if victim.exists() else None) == ('precious\n' if exists else None)
    assert Path(file.path).name == f'lamp_{os.getpid()}_1500000000001.log'
    assert Path(file.path).read_text() == 'x\n'


def test_a_prefix_takes_the_executables_place(folder: Path) -> None:
    configure([], to_console=False, to_file=True, file_prefix='robot')
    get_logger('a').info('x')
    (file,) = folder.iterdir()
    assert file.name.startswith(f'robot_{os.getpid()}_')


def test_there_is_no_file_before_the_first_line(folder: Path) -> None:
    configure([], to_console=False, to_file=True)
    get_logger('a').debug('filtered')
    assert not folder.exists()


def test_a_line_is_on_disk_when_the_call_returns(folder: Path) -> None:
    configure([], to_console=False, to_file=True)
    get_logger('a').info('first')
    get_logger('a').info('second')
    assert [line.rpartition(' ')[2] for line in lines(folder)] == ['first', 'second']


def test_what_utf8_cannot_hold_is_spelt_out(tmp_path: Path) -> None:
    file = LogFile(str(tmp_path), compile_format('{message}'))
    file(record('\udc80 ä'))
    file.close()
    assert Path(file.path).read_text() == '\\udc80 ä\n'


def test_a_closed_file_takes_nothing_and_complains_of_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = LogFile(str(tmp_path), compile_format(DEFAULT_FORMAT))
    file(record('x'))
    file.close()
    file.close()
    file(record('y'))
    assert Path(file.path).read_text() == '[WARN] [1500000000.000000001] [a.b]: x\n'
    assert capsys.readouterr().err == ''


def test_a_folder_that_cannot_be_made_is_one_warning(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv('ROS_LOG_DIR', NO_FOLDER)
    configure([], to_console=True, to_file=True)
    for _ in range(3):
        assert get_logger('a').info('x')
    printed = capsys.readouterr().err
    assert printed.count('[a]: x') == 3
    assert printed.count('Set ROS_LOG_DIR to a folder that can be written') == 1
    assert NO_FOLDER in printed


def test_the_last_release_closes_it(folder: Path) -> None:
    configure([], to_console=False, to_file=True)
    configure([], to_console=False, to_file=True)
    release()
    get_logger('a').info('while one is left')
    release()
    get_logger('a').info('after the end')
    assert len(lines(folder)) == 1


def test_no_line_is_lost_when_the_process_is_killed(folder: Path, isolated: dict[str, str]) -> None:
    program = """
        import os, signal, rclpy
        rclpy.init()
        rclpy.create_node('talker').get_logger().info('last words')
        os.kill(os.getpid(), signal.SIGKILL)
    """
    with Program(program, env={**isolated, 'ROS_LOG_DIR': str(folder)}) as running:
        assert running.wait() < 0
    assert lines(folder)[-1].endswith('[talker]: last words')
