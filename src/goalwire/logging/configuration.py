"""Sets logging up: from the environment at the first record, from the command line by `configure`."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING

from goalwire.logging import dispatch
from goalwire.logging.levels import reset_levels, set_logger_level

if TYPE_CHECKING:
    from pathlib import Path


def configure(levels: Iterable[tuple[str, int]], *, to_console: bool) -> None:
    """Apply what `--ros-args` asked for: levels by logger name ('' for all), and whether to print at all.

    Raises ValueError for a level that is no severity.
    """
    initialize()
    for name, level in levels:
        set_logger_level(name, level)
    dispatch.set_console(enabled=to_console)


def initialize() -> None:
    """Read the environment now, unless that has happened already."""
    dispatch.console()


def shutdown() -> None:
    """Forget levels and environment. Logging goes on with the defaults; sinks stay."""
    reset_levels()
    dispatch.reset_console()


def clear_config() -> None:
    """Begin anew: shutdown() and initialize()."""
    shutdown()
    initialize()


def get_logging_directory() -> Path:
    """Return where log files belong: ROS_LOG_DIR, else ROS_HOME/log, else ~/.ros/log."""
    from pathlib import Path  # a sixth of the import time of this package

    chosen = os.environ.get('ROS_LOG_DIR')
    if chosen:
        return Path(chosen).expanduser()
    return Path(os.environ.get('ROS_HOME') or '~/.ros').expanduser() / 'log'
