"""What became of each step, as a table of text."""

from __future__ import annotations

from humanoid.mission.events import Began, Event, Finished

HEAD = ('', 'step', 'expected', 'happened', 'time')


class Summary:
    """Collects a mission's events."""

    def __init__(self, total: int | None = None) -> None:
        """`total`: the number of steps, if it is known before the first of them begins."""
        self._total = total
        self._began: dict[int, Began] = {}
        self._finished: dict[int, Finished] = {}

    def note(self, event: Event) -> None:
        if isinstance(event, Began):
            self._total = event.total
            self._began[event.number] = event
        elif isinstance(event, Finished):
            self._finished[event.number] = event

    @property
    def begun(self) -> bool:
        return bool(self._began)

    @property
    def complete(self) -> bool:
        """True once every step has ended, one way or the other."""
        return self._total is not None and len(self._finished) == self._total

    @property
    def all_well(self) -> bool:
        """True once every step of the mission has ended as it should."""
        return self.complete and all(event.ok for event in self._finished.values())

    def table(self) -> str:
        """One line a step that began; the last line counts them all."""
        rows = [HEAD, *(self._row(began) for began in self._began.values())]
        widths = [max(len(row[column]) for row in rows) for column in range(len(HEAD))]
        head, *body = ['  '.join(map(str.ljust, row, widths)).rstrip() for row in rows]
        rule = '  '.join('-' * width for width in widths)
        return '\n'.join([head, rule, *body, self._count()])

    def _row(self, began: Began) -> tuple[str, str, str, str, str]:
        finished = self._finished.get(began.number)
        if finished is None:
            return 'cut', began.name, began.expected, 'it did not end', ''
        mark = 'ok' if finished.ok else 'FAILED'
        return mark, began.name, began.expected, finished.happened, f'{finished.seconds:.1f} s'

    def _count(self) -> str:
        well = sum(event.ok for event in self._finished.values())
        took = sum(event.seconds for event in self._finished.values())
        return f'{well} of {self._total or "?"} steps ended as they should, in {took:.1f} s'
