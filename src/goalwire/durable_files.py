"""SQLite files: a commit returns when its data is on the disk, and errors say what to do.

The files use WAL and `synchronous=FULL`. With `synchronous=NORMAL` a power cut may undo the last commit, and
a goal could run whose record is lost.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from goalwire.errors import JournalError

_ADVICE = 'look at the disk, its free space, and who may write there'


class DurableFile:
    """One open SQLite file. One thread at a time may use it."""

    def __init__(self, path: Path, *, wait_s: float, is_exclusive: bool = False) -> None:
        """Open or make the file.

        With `is_exclusive` no other process can open the file until this process ends or closes it. `wait_s`
        is the time in s to wait while another process has the file. Raises JournalError.
        """
        self.path = path
        with self.explaining('opened'):
            self.db = sqlite3.connect(path, timeout=wait_s, isolation_level=None, check_same_thread=False)
            try:
                if is_exclusive:
                    self.db.execute('PRAGMA locking_mode=EXCLUSIVE')
                self.db.execute('PRAGMA journal_mode=WAL')
                self.db.execute('PRAGMA synchronous=FULL')
                self._file = _identity(path)
            except BaseException:
                self.db.close()
                raise

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """Commit all writes of the `with` block together, or none of them if the block raises. Raises
        JournalError.
        """
        with self.explaining('written'):
            if _identity(self.path) != self._file:
                raise JournalError(
                    f"the journal '{self.path}' was deleted or replaced, and what it had is lost: put it "
                    'back, then start this program again'
                )
            self.db.execute('BEGIN IMMEDIATE')
            try:
                yield
                self.db.execute('COMMIT')
            except BaseException:
                if self.db.in_transaction:
                    self.db.execute('ROLLBACK')
                raise

    @contextmanager
    def explaining(self, what: str) -> Iterator[None]:
        """Turn SQLite's errors in the `with` block into JournalError. `what` is 'opened', 'read' or
        'written'.
        """
        try:
            yield
        except sqlite3.Error as error:
            raise JournalError(f"the journal '{self.path}' cannot be {what}: {error}; {_ADVICE}") from error

    def close(self) -> None:
        """Close the file. Idempotent."""
        self.db.close()


def _identity(path: Path) -> tuple[int, int] | None:
    """Return what distinguishes a file from a later file at the same path; None if there is no file."""
    try:
        found = os.stat(path)  # noqa: PTH116 - before each commit
    except OSError:
        return None
    return found.st_dev, found.st_ino
