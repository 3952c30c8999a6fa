"""The pictures and the first figures of two pages are those of their tables."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.markdown import DOCS, rows

from tools import pictures

PERFORMANCE, RELIABILITY = DOCS / 'reference' / 'performance.md', DOCS / 'reference' / 'reliability.md'


@pytest.mark.parametrize(
    ('file', 'draw'), [(pictures.SPEED, pictures.speed), (pictures.FAILING, pictures.failing)]
)
def test_a_picture_is_drawn_from_the_table(file: Path, draw: Callable[[], str]) -> None:
    assert file.read_text(encoding='utf-8') == draw(), 'python -m tools.pictures draws it anew'


def first_figures(page: Path) -> list[str]:
    """Return the figures that are bold above the picture."""
    return re.findall(r'\*\*([\d.,]+)\*\*', page.read_text(encoding='utf-8').split('![')[0])


def test_the_first_figures_about_speed_are_in_the_table() -> None:
    cells = {
        figure for row in rows(PERFORMANCE, 'work') for cell in row for figure in re.findall(r'[\d.,]+', cell)
    }
    figures = first_figures(PERFORMANCE)
    assert len(figures) == 6
    assert set(figures) <= cells


def test_the_first_figures_about_faults_are_those_of_the_tables() -> None:
    sent, lost, killed, items = first_figures(RELIABILITY)
    soak = rows(RELIABILITY, 'run')
    assert int(sent.replace(',', '')) == sum(int(row[1].replace(',', '')) for row in soak)
    assert {row[5].split(' ')[0] for row in soak} == {lost}
    evidence = {fault: zenoh for fault, _, zenoh, _ in rows(RELIABILITY, 'item and fault')}
    assert evidence['1: SIGKILL of the server mid-feedback'].endswith(f'; {killed} s')
    assert len(rows(RELIABILITY, 'item')) == int(items)
