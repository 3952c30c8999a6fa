"""The outputs of a launch: the terminal, and log files in a folder of the launch.

This is `launch.logging` of ROS 2 under the same names. The loggers are Python's, one for each process name
and stream, and get the processes' output line by line. The screen is standard output. If the reader of the
screen has gone, lines go only to the files, and the screen's `on_closed` is called.
"""

from __future__ import annotations

import contextlib
import datetime as dt
import errno
import logging
import os
import socket
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from goalwire.errors import BadLaunchValueError, LaunchError
from goalwire.files import discard_output

_SCREEN = '[{levelname}] [{name}]: {message}'
_SCREEN_WITH_TIME = '{created:.7f} [{levelname}] [{name}]: {message}'
_FILE = '{created:.7f} [{levelname}] [{name}]: {message}'
_LINE_ON_SCREEN, _LINE_IN_FILE = '{message}', '{created:.7f} {message}'
_GONE = frozenset({errno.EPIPE, errno.EIO, errno.EBADF, errno.ENXIO})
"""The error numbers of writing to standard output after its reader or the terminal has gone."""
OUTPUTS: dict[str, dict[str, set[str]]] = {
    'screen': {'both': {'screen'}},
    'log': {'both': {'log'}, 'stderr': {'screen'}},
    'both': {'both': {'screen', 'log'}},
    'own_log': {'both': {'own_log'}, 'stdout': {'own_log'}, 'stderr': {'own_log'}},
    'full': {'both': {'screen', 'log', 'own_log'}, 'stdout': {'own_log'}, 'stderr': {'own_log'}},
}


class _Formatted(logging.Handler):
    """A logging handler with two formats: lines of processes are shown without a prefix."""

    def __init__(self, general: str, line: str) -> None:
        super().__init__()
        self.setFormatter(logging.Formatter(general, style='{'))
        self._line = logging.Formatter(line, style='{')

    def format(self, record: logging.LogRecord) -> str:
        if record.name in launch_config.process_loggers:
            return self._line.format(record)
        return super().format(record)


class _Screen(_Formatted):
    """A logging handler that writes to standard output, which all processes share."""

    def __init__(self, general: str) -> None:
        super().__init__(general, _LINE_ON_SCREEN)
        self.on_closed: Callable[[], None] = lambda: None
        self._closed = False

    def emit(self, record: logging.LogRecord) -> None:
        if self._closed or sys.stdout is None:
            return
        text = self.format(record) + '\n'
        try:
            encoding = getattr(sys.stdout, 'encoding', None) or 'utf-8'
            sys.stdout.write(text.encode(encoding, 'replace').decode(encoding))
            sys.stdout.flush()
        except (OSError, ValueError) as error:
            if isinstance(error, OSError) and error.errno not in _GONE:
                return  # a full disk or a full pipe must not stop the robot
            self._closed = True
            with contextlib.suppress(OSError, ValueError):
                discard_output(1)
            self.on_closed()


class _File(_Formatted):
    """A logging handler that writes to a file, which is opened at its first line."""

    def __init__(self, path: str, general: str, line: str) -> None:
        super().__init__(general, line)
        self._path = path
        self._file: Any = None

    def emit(self, record: logging.LogRecord) -> None:
        with contextlib.suppress(OSError):  # a full disk must not stop the robot
            if self._file is None:
                self._file = open(self._path, 'a', encoding='utf-8', errors='replace')  # noqa: SIM115
            self._file.write(self.format(record) + '\n')
            self._file.flush()

    def close(self) -> None:
        with contextlib.suppress(OSError):
            if self._file is not None:
                self._file.close()
        super().close()


class LaunchConfig:
    """The settings of the launch's logging: formats, level, and the folder of log files."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Restore the initial state: a new folder for log files, and the formats from the environment."""
        for handler in getattr(self, 'file_handlers', {}).values():
            handler.close()
        self._log_dir: str | None = None
        self.log_file_name = 'launch.log'
        self.file_handlers: dict[str, logging.Handler] = {}
        self.process_loggers: set[str] = set()
        self.log_handler_factory: Callable[..., logging.Handler] | None = None
        self.level = logging.INFO
        self.file_format = _format_of('OVERRIDE_LAUNCH_LOG_FORMAT', _FILE)
        self.screen_handler = _Screen(_format_of('OVERRIDE_LAUNCH_SCREEN_FORMAT', _SCREEN))

    @property
    def log_dir(self) -> str:
        """The folder of this launch's log files, made when it is first asked for."""
        if self._log_dir is None:
            base = logging_directory()
            now = dt.datetime.now().strftime('%Y-%m-%d-%H-%M-%S-%f')  # noqa: DTZ005 - the user's time
            folder = base / f'{now}-{socket.gethostname()}-{os.getpid()}'
            try:
                folder.mkdir(parents=True)
            except OSError as error:
                raise LaunchError(
                    f'cannot make the folder of log files {folder}: {error.strerror}; '
                    'ROS_LOG_DIR names another place'
                ) from error
            self._log_dir = str(folder)
            with contextlib.suppress(OSError):
                latest = base / 'latest'
                if latest.is_symlink() or not latest.exists():
                    latest.unlink(missing_ok=True)
                    latest.symlink_to(folder, target_is_directory=True)
        return self._log_dir

    @log_dir.setter
    def log_dir(self, new_log_dir: str | None) -> None:
        if new_log_dir is None:
            self._log_dir = None
            return
        Path(new_log_dir).mkdir(parents=True, exist_ok=True)
        self._log_dir = new_log_dir

    def set_screen_format(self, screen_format: str, *, screen_style: str | None = None) -> None:
        """Set the format of lines on the screen, in the style of str.format()."""
        known = {'default': _SCREEN, 'default_with_timestamp': _SCREEN_WITH_TIME}
        self.screen_handler.setFormatter(
            logging.Formatter(known.get(screen_format, screen_format), style=screen_style or '{')  # type: ignore[arg-type]
        )

    def set_log_format(self, log_format: str, *, log_style: str | None = None) -> None:
        """Set the format of lines in files."""
        self.file_format = _FILE if log_format == 'default' else log_format
        for handler in self.file_handlers.values():
            handler.setFormatter(logging.Formatter(self.file_format, style=log_style or '{'))  # type: ignore[arg-type]

    def get_screen_handler(self) -> _Screen:
        return self.screen_handler

    def get_log_file_path(self, file_name: str = 'launch.log') -> str:
        return str(Path(self.log_dir, file_name))

    def get_log_file_handler(self, file_name: str = 'launch.log') -> logging.Handler:
        """Return a log file's handler. `log_handler_factory(path, encoding=…)`, if set, constructs it."""
        if file_name not in self.file_handlers:
            path = self.get_log_file_path(file_name)
            if self.log_handler_factory is None:
                own = file_name != self.log_file_name
                made: logging.Handler = _File(path, self.file_format, '{message}' if own else _LINE_IN_FILE)
            else:
                made = self.log_handler_factory(path, encoding='utf-8')
                made.setFormatter(logging.Formatter(self.file_format, style='{'))
            self.file_handlers[file_name] = made
        return self.file_handlers[file_name]


def logging_directory() -> Path:
    """Return ROS_LOG_DIR, else ROS_HOME/log, else ~/.ros/log. Raises LaunchError if the user has no home."""
    own = os.environ.get('ROS_LOG_DIR')
    chosen = Path(own) if own else Path(os.environ.get('ROS_HOME') or '~/.ros') / 'log'
    try:
        return chosen.expanduser().absolute()
    except RuntimeError:
        raise LaunchError(
            f'there is no folder for log files: it would be {chosen}, and this user has no home; '
            'let ROS_LOG_DIR name one'
        ) from None


def _format_of(variable: str, otherwise: str) -> str:
    wanted = os.environ.get(variable)
    if not wanted:
        return otherwise
    named = {'default': otherwise, 'default_with_timestamp': _SCREEN_WITH_TIME}
    text = wanted.encode('latin-1', 'replace').decode('unicode_escape').replace('{msg}', '{message}')
    return named.get(wanted, text)


launch_config = LaunchConfig()


def log_launch_config(logger: logging.Logger) -> None:
    """Log the folder of the log files, and the lowest level of shown messages."""
    logger.info(f'All log files can be found below {launch_config.log_dir}')
    logger.info(f'Default logging verbosity is set to {logging.getLevelName(launch_config.level)}')


def get_logger(name: str | None = None) -> logging.Logger:
    """Return a logger that writes to the screen and to launch.log."""
    logger = logging.getLogger(name or 'launch')
    _write_to(
        logger,
        [launch_config.screen_handler, launch_config.get_log_file_handler(launch_config.log_file_name)],
    )
    return logger


def get_output_loggers(
    process_name: str, output_config: str | dict[str, Any]
) -> tuple[logging.Logger, logging.Logger]:
    """Return the loggers for a process's stdout and stderr. Raises LaunchError for an unknown output."""
    config = _destinations(output_config)
    loggers = []
    for stream in ('stdout', 'stderr'):
        wanted = config.get('both', set()) | config.get(stream, set())
        handlers: list[logging.Handler] = []
        if 'screen' in wanted:
            handlers.append(launch_config.screen_handler)
        if 'log' in wanted:
            handlers.append(launch_config.get_log_file_handler(launch_config.log_file_name))
        if 'own_log' in config.get(stream, set()):
            handlers.append(launch_config.get_log_file_handler(f'{process_name}-{stream}.log'))
        if 'own_log' in config.get('both', set()):
            handlers.append(launch_config.get_log_file_handler(f'{process_name}.log'))
        logger = logging.getLogger(f'{process_name}-{stream}')
        launch_config.process_loggers.add(logger.name)
        _write_to(logger, handlers)
        loggers.append(logger)
    return loggers[0], loggers[1]


def _destinations(output: str | dict[str, Any]) -> dict[str, set[str]]:
    if isinstance(output, str):
        if output not in OUTPUTS:
            raise BadLaunchValueError(f"output '{output}' is unknown: use one of {', '.join(OUTPUTS)}")
        return OUTPUTS[output]
    found = {key: {value} if isinstance(value, str) else set(value) for key, value in output.items()}
    if not found.keys() <= {'both', 'stdout', 'stderr'} or not set().union(*found.values()) <= {
        'screen',
        'log',
        'own_log',
    }:
        raise BadLaunchValueError(
            f'output {output!r} is unknown: keys are both, stdout and stderr, values screen, log and own_log'
        )
    return found


def _write_to(logger: logging.Logger, handlers: list[logging.Handler]) -> None:
    known = launch_config.file_handlers.values()
    for handler in list(logger.handlers):
        if handler not in handlers and (isinstance(handler, _Formatted) or handler in known):
            logger.removeHandler(handler)
    for handler in handlers:
        if handler not in logger.handlers:
            logger.addHandler(handler)
    logger.setLevel(launch_config.level)
    logger.propagate = False


def reset() -> None:
    """Reset the logging, for tests and for programs that launch several times."""
    launch_config.reset()
