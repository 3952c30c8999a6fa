"""The log file of a process, `<directory>/<program>_<pid>_<ms>.log` as rcl_logging_spdlog names it.

It is always a new file: if a file or a link of that name exists, the next name is
taken.

Each line is one write to a file opened for appending. So lines stay whole even if several threads log, and no
line is lost if the process is killed. ROS 2, in contrast, keeps up to 5 s of lines below ERROR in memory.
"""

from __future__ import annotations

import os
import sys
import time
from contextlib import suppress
from errno import EEXIST, ENOENT
from io import FileIO

from goalwire.locks import ForkableLock
from goalwire.logging import dispatch
from goalwire.logging.record import Formatter, LoggingSeverity, LogRecord

_ATTEMPTS = 100
"""The number of file names that are tried before the opening fails."""
_NAME_LIMIT = 100


class LogFile:
    """A sink that writes the same lines as the console into a file, without colours."""

    def __init__(self, directory: str, formatter: Formatter, prefix: str | None = None) -> None:
        """`prefix` (`--log-file-name`) replaces the program's name in the name of the file.

        If the program has no name, as with `python -c`, the name of the first logger is used.
        """
        self.path = ''
        """The path of the file; '' before the first line is written."""
        self._directory = directory
        self._prefix = prefix or _program()
        self._ms = time.time_ns() // 1_000_000
        self._format = formatter
        self._lock = ForkableLock()
        self._file: FileIO | None = None
        self._closed = False

    def __call__(self, record: LogRecord) -> None:
        """Write one record. The first failure is reported on the console, and ends the writing."""
        try:
            file = self._file or self._open(record.name)
            if file is not None:
                file.write(f'{self._format(record)}\n'.encode(errors='backslashreplace'))
        except ValueError:  # another thread has closed the file meanwhile
            return
        except OSError as error:
            self.close()
            self._complain(error)

    def close(self) -> None:
        """Stop writing. Idempotent."""
        with self._lock:
            self._closed = True
            file, self._file = self._file, None
        if file is not None:
            file.close()

    def _open(self, logger: str) -> FileIO | None:
        with self._lock:
            if self._file is None and not self._closed:
                if self._directory.startswith('~'):
                    raise FileNotFoundError(ENOENT, 'this user has no home')
                os.makedirs(self._directory, exist_ok=True)  # noqa: PTH103
                self._file = self._new_file(f'{self._prefix or _file_name(logger) or "python"}_{os.getpid()}')
            return self._file

    def _new_file(self, name: str) -> FileIO:
        """Make a new file: its name ends with `_ms`, or with the next number for which no file exists."""
        for ms in range(self._ms, self._ms + _ATTEMPTS):
            self.path = os.path.join(self._directory, f'{name}_{ms}.log')  # noqa: PTH118 - pathlib is slow
            with suppress(FileExistsError):
                return FileIO(self.path, 'a', opener=_open_new)
        raise FileExistsError(EEXIST, os.strerror(EEXIST))

    def _complain(self, error: OSError) -> None:
        dispatch.console()(
            LogRecord(
                time.time_ns(),
                LoggingSeverity.WARN,
                'goalwire.logging',
                f"the log file '{self.path or self._directory}' cannot be written ({error.strerror}); "
                'lines go to the console only. Set ROS_LOG_DIR to a folder that can be written, or give '
                '--ros-args --disable-external-lib-logs',
                '_complain',
                __file__,
                0,
            )
        )


def _open_new(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_EXCL | getattr(os, 'O_NOFOLLOW', 0), 0o666)


def _program() -> str:
    """Return the name of the script or module (ROS 2: the executable); '' if the program has no name."""
    folder, name = os.path.split(sys.argv[0] if sys.argv else '')
    if name == '__main__.py':  # so named under `python -m package`
        name = os.path.basename(folder)  # noqa: PTH119
    return '' if name.startswith('-') else _file_name(name.removesuffix('.py'))  # '-c', '-m', or '-' (stdin)


def _file_name(text: str) -> str:
    """Replace all characters of a text that are unsafe in a file's name, in shells or in terminals."""
    plain = ''.join(sign if sign.isalnum() or sign in '_.-' else '_' for sign in text[:_NAME_LIMIT])
    return plain.lstrip('.')
