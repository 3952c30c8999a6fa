"""The page of differences: one table a section, each call once, each row argued for."""

from __future__ import annotations

import re
from collections import Counter

from helpers.markdown import DOCS

PAGE = DOCS / 'reference' / 'differences-from-rclpy.md'
HEAD = ['Call', 'rclpy', 'goalwire', 'Why']


def _rows(section: str) -> list[list[str]]:
    lines = [line for line in section.splitlines() if line.startswith('|')]
    return [[cell.strip() for cell in line.strip('|').split(' | ')] for line in lines]


def test_each_section_has_one_table_of_full_rows_and_each_call_stands_once() -> None:
    _, *sections = re.split(r'^## ', PAGE.read_text(encoding='utf-8'), flags=re.MULTILINE)
    assert len(sections) > 10
    calls: Counter[str] = Counter()
    for section in sections:
        head, _, *rows = _rows(section)
        assert head == HEAD, section
        for row in rows:
            assert len(row) == 4, row
            assert all(row), row
        calls.update(row[0] for row in rows if not row[0].startswith('…'))
    assert [call for call, count in calls.items() if count > 1] == []
