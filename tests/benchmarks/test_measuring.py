"""The benchmark harness: what it makes of rounds, and that a program of it runs."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from helpers.markdown import ROOT

from benchmarks import markdown, svg
from benchmarks.line import Goal, Line, Of
from benchmarks.lines import asyncio_calls, image
from benchmarks.measuring import Failed, Measured, measure, run
from benchmarks.subjects import (
    DDS,
    DDS_LIBRARY,
    ECLIPSE,
    PEER,
    RAW_DDS,
    RAW_NATIVE,
    TCP,
    ZENOH,
    ZENOH_NO_LOOK,
    Subject,
)
from benchmarks.verdicts import judge

LINE = Line(
    'a call', 'nowhere', 10, ('p50',),
    (
        Goal('p50', Of.REFERENCE, 0.5, 0.1),
        Goal('p50', Of.RAW, 2, 2),
        Goal('p50', Of.ONE, 60, 30, at_least=True),
        Goal('p50', Of.TCP, 4, None, no_look=7),
        Goal('p50', Of.ECLIPSE, 0.5, None),
    ),
    {'p50': 100.0},
)  # fmt: skip
MEASURED = Measured(
    LINE,
    {
        ZENOH.name: [{'p50': 40.0}, {'p50': 90.0}, {'p50': 50.0}],
        RAW_NATIVE.name: [{'p50': 20.0}, {'p50': 30.0}, {'p50': 30.0}],
        ZENOH_NO_LOOK.name: [{'p50': 80.0}],
        TCP.name: [{'p50': 10.0}],
        ECLIPSE.name: [{'p50': 100.0}],
        DDS.name: [{'p50': 20.0}],
        DDS_LIBRARY.name: [{'p50': 40.0}],
        PEER: [{'p50': 200.0}, {'p50': 200.0}, {'p50': 200.0}],
    },
    {RAW_DDS.name: 'it is not here'},
)


def subject(code: str) -> Subject:
    return Subject('somebody', 'goalwire_memory', lambda _: ['timeit', '-n', '1', '-r', '1', code])


def test_a_figure_is_the_median_of_the_rounds_and_a_ratio_that_of_each_rounds_own() -> None:
    assert MEASURED.figure(ZENOH.name, 'p50') == 50.0
    assert MEASURED.ratio(ZENOH.name, RAW_NATIVE.name, 'p50') == 2.0
    assert MEASURED.spread(ZENOH.name, 'p50') == 1.0


def test_goals_are_judged_by_what_they_are_multiples_of() -> None:
    verdicts = {(one.goal.of, one.subject): (one.multiple, one.met, one.peer) for one in judge(MEASURED)}
    assert verdicts == {
        (Of.REFERENCE, ZENOH.name): (0.5, True, 0.25),
        (Of.REFERENCE, DDS.name): (0.2, False, 0.1),
        (Of.RAW, ZENOH.name): (2.0, True, None),
        (Of.RAW, DDS.name): (None, None, None),
        (Of.ONE, ZENOH.name): (50.0, False, None),
        (Of.ONE, DDS.name): (20.0, False, None),
        (Of.TCP, ZENOH.name): (4.0, True, None),
        (Of.TCP, ZENOH_NO_LOOK.name): (8.0, False, None),
        (Of.ECLIPSE, ZENOH.name): (0.4, True, None),
    }


def test_the_report_shows_goals_figures_and_who_could_not_be_measured() -> None:
    text = markdown.report({'Python': '3'}, [MEASURED], '')
    assert '| a call | Zenoh | p50 | 50 µs | ≤ 0.5 of the reference | 0.5 | yes | 0.25 | yes |' in text
    assert '| a call | no look | p50 | 80 µs | ≤ 7 of Python on TCP | 8 | **no** |' in text
    goalwire = "Zenoh | no look | eclipse-zenoh's session | DDS | libddsc's session"
    assert f'| work | {goalwire} | rclpy beside | reference |' in text
    assert '| a call: p50, µs | 50 (100%) | 80 (0%) | 100 (0%) | 20 (0%) | 40 (0%) | 200 (0%) | 100 |' in text
    assert '- a call: it is not here' in text


def test_plots_are_well_formed_and_hold_every_point() -> None:
    curves = svg.curves('<title>', 'x', 'y', {'a': [(1, 10), (1000, 0.5)], 'b & c': [(5, 5)]})
    rows = svg.rows('title', 'multiple', {'call': {'a': 1.0, 'b': 20.0}})
    for plot, points in ((curves, 3), (rows, 2)):
        circles = list(ET.fromstring(plot).iter('{http://www.w3.org/2000/svg}circle'))
        assert len(circles) == points + 2  # and one for each name of the legend


def test_an_axis_is_logarithmic_and_its_ticks_are_round() -> None:
    axis = svg.Axis('', 1.0, 100.0, 0.0, 200.0)
    assert axis.at(10.0) == pytest.approx(100.0)
    assert axis.ticks() == [1, 2, 5, 10, 20, 50, 100]


def test_who_fails_is_named_with_his_last_words_and_not_asked_again() -> None:
    with pytest.raises(Failed, match='somebody: ZeroDivisionError: division by zero'):
        run(subject('1/0'), LINE)
    result = measure(LINE, [subject('1/0')], rounds=3, count=1)
    assert list(result.failures) == ['somebody']
    assert result.rounds == {}


@pytest.mark.slow
def test_a_line_is_measured_and_reported_in_three_forms(tmp_path: Path) -> None:
    command = [sys.executable, '-m', 'benchmarks', '--alone', '--only', 'timer']
    options = ['--rounds', '1', '--scale', '0.01', '--out', str(tmp_path)]
    subprocess.run([*command, *options], cwd=ROOT, check=True, timeout=300, stdout=subprocess.DEVNULL)
    (line,) = json.loads((tmp_path / 'report.json').read_text(encoding='utf-8'))['lines'].values()
    assert set(line['failures']) <= {DDS.name}  # not every platform has that library
    assert {ZENOH.name, ECLIPSE.name} <= set(line['rounds'])
    assert (tmp_path / 'report.md').exists()
    assert (tmp_path / 'report.svg').exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ('floor', 'line'),
    [
        (RAW_NATIVE, image.LINE),
        (RAW_NATIVE, asyncio_calls.LINE),
        (TCP, image.LINE),
        (TCP, asyncio_calls.LINE),
    ],
)
def test_a_floor_does_the_work_of_a_line(floor: Subject, line: Line) -> None:
    figures = run(floor, line, 3)
    assert figures is not None
    assert figures['p50'] > 0
