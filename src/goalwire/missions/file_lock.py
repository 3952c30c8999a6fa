"""A lock file beside a journal, which a runner holds as long as it lives. The lock ends with the process."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from goalwire.errors import JournalError
from goalwire.rules.missions.holding import Sighting

_LARGEST = 200


class FileLock:
    """A lock that is held from its creation to `close`. Its file also has the last time of a sign of life."""

    def __init__(self, path: Path) -> None:
        """Take the lock. Raises JournalError if another runner has it, or the file cannot be made."""
        try:
            self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise JournalError(f"'{path}' cannot be opened: {error.strerror}") from error
        is_taken = _try_to_lock(self._descriptor)
        while not is_taken and not _is_locked(self._descriptor):  # someone has just asked has_runner
            is_taken = _try_to_lock(self._descriptor)
        if not is_taken:
            os.close(self._descriptor)
            raise JournalError(
                f"another runner has '{path}': a journal has only one runner, so that no step runs twice"
            )

    def read_last_seen(self) -> Sighting | None:
        """Return the last sign of life of a holder; None if there was none."""
        os.lseek(self._descriptor, 1, os.SEEK_SET)
        boot, _, steady = os.read(self._descriptor, _LARGEST).decode(errors='replace').strip().rpartition(' ')
        try:
            return Sighting(boot, float(steady)) if boot else None
        except ValueError:
            return None

    def note(self, now: Sighting) -> None:
        """Record a sign of life. It outlives the process, but perhaps not a crash of the machine."""
        text = f' {now.boot} {now.steady:.3f}\n'.encode().ljust(_LARGEST)
        os.lseek(self._descriptor, 0, os.SEEK_SET)  # on Windows the first byte is locked
        os.write(self._descriptor, text)

    def close(self) -> None:
        """Release the lock. Idempotent."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def lock_path(journal: Path) -> Path:
    """Return the path of a journal's lock file."""
    return journal.with_name(f'{journal.name}.lock')


def has_runner(journal: Path) -> bool:
    """Return whether a runner, of this process or another one, has a journal now.

    If the lock file cannot be opened by this user, the answer is yes: nobody can claim the contrary.
    """
    try:
        descriptor = os.open(lock_path(journal), os.O_RDONLY)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    try:
        return _is_locked(descriptor)
    finally:
        os.close(descriptor)


if sys.platform == 'win32':
    import msvcrt

    def _try_to_lock(descriptor: int) -> bool:
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

    def _is_locked(descriptor: int) -> bool:
        """Return whether a runner has locked the first byte: then nobody else can read it."""
        os.lseek(descriptor, 0, os.SEEK_SET)
        try:
            os.read(descriptor, 1)
        except PermissionError:
            return True
        return False

else:
    import fcntl

    def _try_to_lock(descriptor: int) -> bool:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True

    def _is_locked(descriptor: int) -> bool:
        """Return whether a runner has the lock. A shared lock, which is given back at once, tells that."""
        try:
            fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError:
            return True
        fcntl.flock(descriptor, fcntl.LOCK_UN)
        return False
