"""Shows how each step ended, as a table of text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from textwrap import wrap

from humanoid.mission.events import Began, Event, Finished
from humanoid.text import columns

GAP = '  '
NARROWEST = 6  # the least width of a column, in characters
HEAD = ('', 'step', 'expected', 'happened', 'time')


class Summary:
    """Collects a mission's events."""

    def __init__(self, total: int | None = None) -> None:
        """`total`: the number of steps, if it is known before the first step begins."""
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
        """True once every step has ended, in success or failure."""
        return self._total is not None and len(self._finished) == self._total

    @property
    def all_well(self) -> bool:
        """True once every step of the mission has ended as it should."""
        return self.complete and all(event.ok for event in self._finished.values())

    def table(self) -> str:
        """Return a row for each step that began, no wider than the terminal, and a line with the totals."""
        rows = [HEAD, *(self._row(began) for began in self._began.values())]
        widths = _fit([max(len(row[column]) for row in rows) for column in range(len(HEAD))], columns())
        head, *body = ['\n'.join(_lines(row, widths)) for row in rows]
        rule = GAP.join('-' * width for width in widths)
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


def _fit(widths: Sequence[int], whole: int) -> list[int]:
    """Return the columns' widths; the widest is made narrower until all fit `whole` characters."""
    fitted = list(widths)
    while sum(fitted) + len(GAP) * (len(fitted) - 1) > whole and max(fitted) > NARROWEST:
        fitted[fitted.index(max(fitted))] -= 1
    return fitted


def _lines(row: Sequence[str], widths: Sequence[int]) -> Iterator[str]:
    """Return the lines of one row; text that is too long for its column continues below."""
    cells = [
        wrap(text, max(width, 1), break_on_hyphens=False) for text, width in zip(row, widths, strict=True)
    ]
    for parts in zip_longest(*cells, fillvalue=''):
        yield GAP.join(map(str.ljust, parts, widths)).rstrip()
