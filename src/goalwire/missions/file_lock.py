"""A lock beside a journal's file, which a runner holds as long as it lives. It ends with its process."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from goalwire.errors import JournalError
from goalwire.rules.missions.holding import Sighting

_LARGEST = 200


class FileLock:
    """Held from its making to `close`. The file also says when its holder was last seen alive."""

    def __init__(self, path: Path) -> None:
        """Take the lock. Raises JournalError if another runner has it, or the file cannot be made."""
        try:
            self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise JournalError(f"'{path}' cannot be opened: {error.strerror}") from error
        if not _try_to_lock(self._descriptor):
            os.close(self._descriptor)
            raise JournalError(
                f"another runner has '{path}': one runner a journal, so that no step runs twice"
            )

    def last_seen(self) -> Sighting | None:
        """Return when a holder was last seen; None if nobody was."""
        os.lseek(self._descriptor, 1, os.SEEK_SET)
        boot, _, steady = os.read(self._descriptor, _LARGEST).decode(errors='replace').strip().rpartition(' ')
        try:
            return Sighting(boot, float(steady)) if boot else None
        except ValueError:
            return None

    def note(self, now: Sighting) -> None:
        """Say that the holder is alive. This survives the process, and need not survive the machine."""
        text = f' {now.boot} {now.steady:.3f}\n'.encode().ljust(_LARGEST)
        os.lseek(self._descriptor, 0, os.SEEK_SET)  # the first byte is the locked one on Windows
        os.write(self._descriptor, text)

    def close(self) -> None:
        """Release the lock. Idempotent."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


if sys.platform == 'win32':
    import msvcrt

    def _try_to_lock(descriptor: int) -> bool:
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:
    import fcntl

    def _try_to_lock(descriptor: int) -> bool:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True
