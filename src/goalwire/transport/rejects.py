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
        with self._lock:
            self._counts[kind] += 1
            is_first = self._counts[kind] == 1
        if is_first:
            from logging import getLogger  # heavy, and needed only when something is broken

            getLogger('goalwire.transport').warning(
                '%s ignored (further ones are only counted): %s', kind, reason
            )

    def counts(self) -> dict[str, int]:
        """Return the count of every kind seen."""
        with self._lock:
            return dict(self._counts)
