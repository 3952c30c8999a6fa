"""SQLite files whose commits are on the disk when they return, and whose errors say what to do.

Durable means WAL and `synchronous=FULL`. With NORMAL a power cut may take back the last commit, and a goal
could run whose record is lost.
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
    """One open file. One thread at a time may use it."""

    def __init__(self, path: Path, *, wait_s: float, is_exclusive: bool = False) -> None:
        """Open or make the file.

        With `is_exclusive` no other process can open it until this one ends or closes it. `wait_s` is the
        time for which another holder is waited for. Raises JournalError.
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
        """Commit all writes of the block together, or none of them if it raises. Raises JournalError."""
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
        """Turn SQLite's errors into JournalError. `what` is 'opened', 'read' or 'written'."""
        try:
            yield
        except sqlite3.Error as error:
            raise JournalError(f"the journal '{self.path}' cannot be {what}: {error}; {_ADVICE}") from error

    def close(self) -> None:
        """Close the file. Idempotent."""
        self.db.close()


def _identity(path: Path) -> tuple[int, int] | None:
    """Return what tells a file from another one of the same name; None if there is none."""
    try:
        found = os.stat(path)  # noqa: PTH116 - before each commit
    except OSError:
        return None
    return found.st_dev, found.st_ino
