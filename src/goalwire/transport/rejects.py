"""What arrived and broke the rules: counted by kind, logged the first time, never more."""

from __future__ import annotations

from collections import Counter
from threading import Lock


class Rejects:
    """Counts per kind of fault; safe from any thread."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._counts: Counter[str] = Counter()

    def add(self, kind: str, reason: object) -> None:
        """Count one; the first of a kind is logged as a warning."""
        if self.count(kind):
            self.warn(kind, reason)

    def count(self, kind: str) -> bool:
        """Count one; True where it is the first of its kind, which its finder warns of."""
        with self._lock:
            self._counts[kind] += 1
            return self._counts[kind] == 1

    def warn(self, kind: str, reason: object) -> None:
        """Log the first of a kind."""
        from logging import getLogger  # heavy, and needed only when something is broken

        getLogger('goalwire.transport').warning(
            '%s ignored (further ones are only counted): %s', kind, reason
        )

    def counts(self) -> dict[str, int]:
        """Return the count of every kind seen."""
        with self._lock:
            return dict(self._counts)
