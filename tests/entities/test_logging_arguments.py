"""The effect that the arguments about logging have on a context."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from goalwire.entities.context import Context
from goalwire.errors import RCLError
from goalwire.logging import get_logger


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the log files go."""
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path))
    return tmp_path


@contextmanager
def opened(*arguments: str, initialize_logging: bool = True) -> Iterator[Context]:
    context = Context()
    context.init(['--ros-args', *arguments], initialize_logging=initialize_logging)
    yield context
    context.shutdown()


def texts(folder: Path) -> list[str]:
    return [line.partition(']: ')[2] for file in folder.iterdir() for line in file.read_text().splitlines()]


def test_lines_go_to_a_file_from_init_to_shutdown(folder: Path) -> None:
    get_logger('a').info('before')
    with opened():
        get_logger('a').info('between')
    get_logger('a').info('after')
    assert texts(folder) == ['between']


@pytest.mark.parametrize(
    ('arguments', 'count'),
    [
        (['--disable-external-lib-logs'], 0),
        (['--disable-external-lib-logs', '--enable-external-lib-logs'], 1),
        (['--disable-stdout-logs'], 1),
    ],
)
def test_the_file_can_be_switched_off(folder: Path, arguments: list[str], count: int) -> None:
    with opened(*arguments):
        get_logger('a').info('x')
    assert len(list(folder.iterdir())) == count


def test_the_files_name_can_be_chosen(folder: Path) -> None:
    with opened('--log-file-name', 'robot'):
        get_logger('a').info('x')
    (file,) = folder.iterdir()
    assert file.name.startswith('robot_')


def test_a_context_may_leave_logging_alone(folder: Path) -> None:
    with opened(initialize_logging=False):
        get_logger('a').info('x')
    assert list(folder.iterdir()) == []


def test_a_configuration_file_is_refused() -> None:
    with pytest.raises(RCLError, match=r"^failed to initialize logging: 'my\.conf' cannot be used"):
        Context().init(['--ros-args', '--log-config-file', 'my.conf'])
    with opened('--log-config-file', 'my.conf', '--disable-external-lib-logs'):
        pass
