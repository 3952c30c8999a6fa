from __future__ import annotations

import io
import sys

import pytest
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from humanoid.mission.display import Bars, PlainLines, display
from humanoid.mission.events import Began, Event, Finished, Progressed, Retrying

STORY: list[Event] = [
    Began(1, 2, 'battery', 'answers'),
    Retrying(1, 1, 0.2, 'no server'),
    Finished(1, ok=True, happened='79 %', seconds=1.0),
    Began(2, 2, 'drive', 'SUCCEEDED'),
    *(Progressed(2, tenth / 10, f'{10 - tenth} m to go') for tenth in range(11)),
    Finished(2, ok=False, happened='ABORTED [late]', seconds=2.0),
]


def test_plain_lines_tell_beginnings_retries_quarters_and_ends(capsys: pytest.CaptureFixture[str]) -> None:
    show = PlainLines()
    for event in STORY:
        show(event)
    assert capsys.readouterr().out.splitlines() == [
        '[1/2] battery (expected: answers)',
        '    attempt 1: no server; next in 0.2 s',
        '    ok: 79 % (1.0 s)',
        '[2/2] drive (expected: SUCCEEDED)',
        '     30%  7 m to go',
        '     50%  5 m to go',
        '     80%  2 m to go',
        '    100%  0 m to go',
        '    FAILED: ABORTED [late] (2.0 s)',
    ]


def test_bars_show_each_step_with_its_end() -> None:
    screen = Console(file=io.StringIO(), width=100)
    with Progress(TextColumn('{task.description}', markup=False), BarColumn(), console=screen) as progress:
        show = Bars(progress)
        for event in STORY[:-1]:
            show(event)
        assert [task.percentage for task in progress.tasks] == [100.0, 100.0]
        show(STORY[-1])
        described = [task.description for task in progress.tasks]
    assert described == [' 1/2 battery: ok: 79 %', ' 2/2 drive: FAILED: ABORTED [late]']


def test_without_a_terminal_the_lines_are_plain() -> None:
    with display() as show:
        assert isinstance(show, PlainLines)


def test_without_rich_the_lines_are_plain_even_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.stdout, 'isatty', lambda: True)
    monkeypatch.setitem(sys.modules, 'rich.progress', None)
    with display() as show:
        assert isinstance(show, PlainLines)


def test_with_rich_and_a_terminal_there_are_bars(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.stdout, 'isatty', lambda: True)
    with display() as show:
        assert isinstance(show, Bars)
