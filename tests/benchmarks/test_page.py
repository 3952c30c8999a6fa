"""The figures of a run get into the page on performance, in the places that the page has for them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.markdown import DOCS

from benchmarks import page
from benchmarks.lines import service_spin, startup, topic_throughput
from benchmarks.markdown import NOTHING
from benchmarks.subjects import DDS, DDS_LIBRARY, PEER, RAW_NATIVE, ZENOH, ZENOH_NO_LOOK
from benchmarks.table import LINES

FACTS = {name: name for name in ('taken', 'load before', 'machine', 'Python', 'Zenoh', 'DDS', 'rclpy')}
MEASURED = {
    service_spin.LINE.name: {
        ZENOH.name: [{'p50': 54.0, 'cpu': 120.0}],
        ZENOH_NO_LOOK.name: [{'p50': 216.0, 'cpu': 140.0}],
        RAW_NATIVE.name: [{'p50': 40.0, 'cpu': 70.0}],
        DDS.name: [{'p50': 181.0, 'cpu': 195.0}],
        DDS_LIBRARY.name: [{'p50': 174.0, 'cpu': 190.0}],
        PEER: [{'p50': 278.0, 'cpu': 498.0}],
    },
    topic_throughput.LINE.name: {
        ZENOH.name: [{'rate': 130_000.0, 'cpu_here': 8.2}],
        DDS.name: [{'rate': 94_700.0, 'cpu_here': 10.0}],
        PEER: [{'rate': 5_600.0, 'cpu_here': 159.0}],
    },
    startup.LINE.name: {
        ZENOH.name: [{'inside': 87.0}],
        DDS.name: [{'inside': 97.0}],
        PEER: [{'inside': 418.0}],
    },
}


@pytest.fixture
def run(tmp_path: Path) -> page.Run:
    """The report of a run of three lines, read again."""
    lines = {name: {'rounds': rounds, 'failures': {}, 'goals': []} for name, rounds in MEASURED.items()}
    report = tmp_path / 'report.json'
    report.write_text(json.dumps({'facts': FACTS, 'lines': lines}), encoding='utf-8')
    return page.read(report)


def test_every_row_is_of_a_line_of_the_table_and_of_a_figure_that_it_has() -> None:
    assert {row.line.name for row in page.ROWS} == {line.name for line in LINES}
    for row in page.ROWS:
        assert set(row.figures) <= set(row.line.figures), row.name
    assert len({row.name for row in page.ROWS}) == len(page.ROWS)


def test_the_head_names_six_figures_in_bold(run: page.Run) -> None:
    text = '\n'.join(page.head(run))
    assert text.count('**') == 12
    assert '**54** µs on Zenoh and **181** µs on DDS' in text
    assert '**130,000** messages a second on Zenoh' in text


def test_a_cell_is_bold_where_every_goal_of_its_figures_is_met(run: page.Run) -> None:
    text = '\n'.join(page.tables(run))
    call = 'service call, `call_async` + `spin_until_future_complete`'
    assert f'| {call} | **54** | 216 | {NOTHING} | 181 | 174 | 278 | 216 |' in text
    assert f'| the same, CPU of both processes | **120** | 140 | {NOTHING} | 195 | 190 | 498 | 430 |' in text
    assert f'| 32 calls in flight, calls/s; lost | {NOTHING} |' in text
    assert f'| {call} | **54** | 40 | {NOTHING} | 216 | {NOTHING} |' in text


def test_what_is_not_met_is_told_with_the_goal(run: page.Run) -> None:
    found = list(page.not_met(run))
    assert f'- {service_spin.LINE.name}, p50, no look: 1 of the reference, asked ≤ 0.55' in found
    assert not [text for text in found if ', p50, Zenoh:' in text]


def test_only_what_stands_between_the_comments_is_replaced() -> None:
    before = (DOCS / 'reference' / 'performance.md').read_text(encoding='utf-8')
    after = page.filled(before, {'head': 'HEAD', 'tables': 'TABLES'})
    assert '<!-- bench: head -->\nHEAD\n<!-- bench: end -->' in after
    assert '<!-- bench: tables -->\nTABLES\n<!-- bench: end -->' in after
    assert after.partition('## How it scales')[2] == before.partition('## How it scales')[2]
    with pytest.raises(SystemExit, match='no place for tables'):
        page.filled('<!-- bench: head -->\n<!-- bench: end -->', {'tables': ''})
