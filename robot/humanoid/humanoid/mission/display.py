"""Shows a mission on the screen: with progress bars if `rich` is installed, else with plain lines."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from humanoid.mission.events import Began, Event, Finished, Progressed, Retrying, Sink
from humanoid.text import indent

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID


@contextmanager
def display() -> Iterator[Sink]:
    """Give a function that shows each event passed to it."""
    if sys.stdout.isatty():
        try:
            from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
            from rich.table import Column
        except ImportError:
            pass
        else:
            one_line = Column(no_wrap=True, overflow='ellipsis', ratio=1)
            text = TextColumn('{task.description}', markup=False, table_column=one_line)
            with Progress(BarColumn(bar_width=12), TimeElapsedColumn(), text, expand=True) as progress:
                yield Bars(progress)
            return
    yield PlainLines()


class Bars:
    """Shows a bar for each step. Rich is optional: a plain ROS 2 installation lacks it."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._tasks: dict[int, TaskID] = {}
        self._names: dict[int, str] = {}

    def __call__(self, event: Event) -> None:
        number = event.number
        if isinstance(event, Began):
            self._names[number] = f'{number:2}/{event.total} {event.name}'
            self._tasks[number] = self._progress.add_task(self._names[number], total=1.0)
        elif isinstance(event, Progressed):
            self._show(number, event.text, completed=event.fraction)
        elif isinstance(event, Retrying):
            self._show(number, f'attempt {event.attempt} failed, next in {event.wait:.1f} s')
        else:
            self._show(number, ('ok: ' if event.ok else 'FAILED: ') + event.happened, completed=1.0)
            self._progress.stop_task(self._tasks[number])

    def _show(self, number: int, text: str, completed: float | None = None) -> None:
        self._progress.update(
            self._tasks[number], description=f'{self._names[number]}: {text}', completed=completed
        )


class PlainLines:
    """Prints a line for each start, end and retry of a step, and for each quarter of its progress."""

    def __init__(self) -> None:
        self._quarter = 0

    def __call__(self, event: Event) -> None:
        if isinstance(event, Began):
            self._quarter = 0
            _print(f'[{event.number}/{event.total}] {event.name} (expected: {event.expected})')
        elif isinstance(event, Progressed):
            quarter = int(event.fraction * 4)
            if quarter > self._quarter:
                self._quarter = quarter
                _print(f'    {event.fraction:4.0%}  {event.text}')
        elif isinstance(event, Retrying):
            _print(f'    attempt {event.attempt}: {event.reason}; next in {event.wait:.1f} s')
        elif isinstance(event, Finished):
            mark = 'ok' if event.ok else 'FAILED'
            _print(f'    {mark}: {event.happened} ({event.seconds:.1f} s)')


def _print(text: str) -> None:
    print(indent(text), flush=True)
