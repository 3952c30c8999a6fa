"""Configures logging: from the environment at the first record, from the command line by `configure`."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING

from goalwire.locks import ForkableLock
from goalwire.logging import dispatch
from goalwire.logging.levels import reset_levels, set_logger_level

if TYPE_CHECKING:
    from pathlib import Path

    from goalwire.logging.log_file import LogFile

_lock = ForkableLock()
_users = 0
_file: tuple[LogFile, dispatch.SinkHandle] | None = None


def configure(
    levels: Iterable[tuple[str, int]],
    *,
    to_console: bool,
    to_file: bool = False,
    file_prefix: str | None = None,
) -> None:
    """Apply what `--ros-args` asked for: levels by logger name ('' for all), and where lines go.

    As in ROS 2 the first user of a process decides, and the others change nothing; each calls `release` once.
    Raises ValueError for a level that is not a severity.
    """
    global _users  # noqa: PLW0603 - logging is the process's, as in ROS 2
    with _lock:
        if not _users:
            initialize()
            for name, level in levels:
                set_logger_level(name, level)
            dispatch.set_console(enabled=to_console)
            if to_file:
                _open_file(file_prefix)
        _users += 1


def release() -> None:
    """End one use: with the last one the log file closes, and lines go to the console again."""
    global _users  # noqa: PLW0603
    with _lock:
        _users -= 1
        if not _users:
            dispatch.set_console(enabled=True)
            _close_file()


def users() -> int:
    """Return how many have configured logging and not released it."""
    return _users


def _open_file(prefix: str | None) -> None:
    global _file  # noqa: PLW0603
    from goalwire.logging.log_file import LogFile

    file = LogFile(_directory(), dispatch.console().format, prefix)
    _file = file, dispatch.add_sink(file)


def _close_file() -> None:
    global _file  # noqa: PLW0603
    if _file is not None:
        file, handle = _file
        _file = None
        handle.close()
        file.close()


def initialize() -> None:
    """Read the environment now, unless that has happened already."""
    dispatch.console()


def shutdown() -> None:
    """Forget levels and environment. Logging goes on with the defaults; sinks stay."""
    reset_levels()
    dispatch.reset_console()


def clear_config() -> None:
    """Start anew: shutdown() and initialize()."""
    shutdown()
    initialize()


def get_logging_directory() -> Path:
    """Return where log files belong: ROS_LOG_DIR, else ROS_HOME/log, else ~/.ros/log."""
    from pathlib import Path  # a sixth of the import time of this package

    return Path(_directory())


def _directory() -> str:
    chosen = os.environ.get('ROS_LOG_DIR') or os.path.join(os.environ.get('ROS_HOME') or '~/.ros', 'log')  # noqa: PTH118
    return os.path.expanduser(chosen)  # noqa: PTH111
