"""The log file of a process, `<directory>/<executable>_<pid>_<ms>.log` as rcl_logging_spdlog names it.

Each line is one write to a file opened for appending: so lines stay whole whichever threads log, and none is
lost however the process ends. ROS 2 keeps up to 5 s of lines below ERROR in memory.
"""

from __future__ import annotations

import os
import sys
import time
from io import FileIO
from threading import Lock

from goalwire.logging import dispatch
from goalwire.logging.format import Formatter
from goalwire.logging.record import LogRecord
from goalwire.logging.severity import LoggingSeverity


class LogFile:
    """A sink that writes lines as the console does, without colours."""

    def __init__(self, directory: str, formatter: Formatter, prefix: str | None = None) -> None:
        """`prefix` stands in the file's name in place of the executable's (`--log-file-name`)."""
        name = f'{prefix or _executable()}_{os.getpid()}_{time.time_ns() // 1_000_000}.log'
        self.path = os.path.join(directory, name)  # noqa: PTH118 - pathlib is slow to import
        self._format = formatter
        self._lock = Lock()
        self._file: FileIO | None = None
        self._closed = False

    def __call__(self, record: LogRecord) -> None:
        """Write one record. The first failure is told on the console; after it nothing is tried again."""
        try:
            file = self._file or self._open()
            if file is not None:
                file.write(f'{self._format(record)}\n'.encode(errors='backslashreplace'))
        except ValueError:  # closed by another thread in the meantime
            return
        except OSError as error:
            self.close()
            self._complain(error)

    def close(self) -> None:
        """Write nothing more. Idempotent."""
        with self._lock:
            self._closed = True
            file, self._file = self._file, None
        if file is not None:
            file.close()

    def _open(self) -> FileIO | None:
        with self._lock:
            if self._file is None and not self._closed:
                os.makedirs(os.path.dirname(self.path), exist_ok=True)  # noqa: PTH103, PTH120
                self._file = FileIO(self.path, 'a')
            return self._file

    def _complain(self, error: OSError) -> None:
        dispatch.console()(
            LogRecord(
                time.time_ns(),
                LoggingSeverity.WARN,
                'goalwire.logging',
                f"the log file '{self.path}' cannot be written ({error.strerror}); lines go to the console "
                'only. Set ROS_LOG_DIR to a folder that can be written, or give '
                '--ros-args --disable-external-lib-logs',
                '_complain',
                __file__,
                0,
            )
        )


def _executable() -> str:
    """Return the program's name as ROS 2 sees it: that of the interpreter, as it was called."""
    called = sys.orig_argv[0] if sys.orig_argv else ''
    return os.path.basename(called or sys.executable) or 'python'  # noqa: PTH119
