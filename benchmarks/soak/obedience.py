"""The commands that servers hear from commanders (commanders.py)."""

from __future__ import annotations

from threading import Lock

from benchmarks.soak.report import Report


class Obedience:
    """The commands that one server has heard."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._lock = Lock()
        self._counts: dict[str, int] = {}

    def hear(self, kind: str, number: int) -> None:
        """Note a command; one from after its sender's end is told at once."""
        if number < 0:
            self._report.say('late', kind, number)
        with self._lock:
            count = self._counts.get(kind, 0) + 1
            self._counts[kind] = count % 100
        if count == 100:
            self._report.say('commanded', kind, count)
