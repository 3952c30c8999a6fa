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
    """Apply the options of `--ros-args`: levels by the names of loggers ('' for all), and where lines go.

    As in ROS 2, the first call in a process decides, and later calls change nothing. Each caller calls
    `release` once. Raises ValueError for a level that is not a severity.
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
    """Undo one `configure`. The last `release` closes the log file, and lines go to the console again."""
    global _users  # noqa: PLW0603
    with _lock:
        _users -= 1
        if not _users:
            dispatch.set_console(enabled=True)
            _close_file()


def users() -> int:
    """Return how many callers of `configure` have not called `release` yet."""
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
    """Read the environment variables for logging now, unless they were read before."""
    dispatch.console()


def shutdown() -> None:
    """Forget all levels, and read the environment again at the next record. Logging goes on; sinks stay."""
    reset_levels()
    dispatch.reset_console()


def clear_config() -> None:
    """Configure anew: call shutdown(), then initialize()."""
    shutdown()
    initialize()


def get_logging_directory() -> Path:
    """Return the folder for log files: ROS_LOG_DIR, else ROS_HOME/log, else ~/.ros/log."""
    from pathlib import Path  # a sixth of this package's import time

    return Path(_directory())


def _directory() -> str:
    chosen = os.environ.get('ROS_LOG_DIR') or os.path.join(os.environ.get('ROS_HOME') or '~/.ros', 'log')  # noqa: PTH118
    return os.path.expanduser(chosen)  # noqa: PTH111
