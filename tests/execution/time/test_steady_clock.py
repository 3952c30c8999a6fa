"""Times that programs give."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import pytest

from goalwire.execution.time import steady_clock
from goalwire.execution.time.steady_clock import STEADY, deadline_after, timeout_ns


def test_a_timeout_is_a_century_at_most() -> None:
    assert timeout_ns(1.5) == 1_500_000_000
    assert timeout_ns(float('inf')) == timeout_ns(1e300) == timeout_ns(10**30) == 4_000_000_000_000_000_000


@pytest.mark.parametrize(('wrong', 'kind'), [('1', TypeError), ([1], TypeError), (float('nan'), ValueError)])
def test_what_is_no_time_is_named(wrong: Any, kind: type[Exception]) -> None:
    with pytest.raises(kind, match='grace is a number of seconds, not '):
        timeout_ns(wrong, 'grace')
    with pytest.raises(kind, match='a timeout is a number of seconds, not '):
        deadline_after(STEADY, wrong)


def test_negative_timeouts_of_rclpy_have_no_end() -> None:
    assert deadline_after(STEADY, -1e-12) is deadline_after(STEADY, None) is None


def test_the_machines_time_is_read_in_one_file_alone() -> None:
    folder = Path(steady_clock.__file__).parents[1]
    readers = set()
    for file in folder.rglob('*.py'):
        for node in ast.walk(ast.parse(file.read_text(encoding='utf-8'))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if 'time' in names or (isinstance(node, ast.ImportFrom) and node.module == 'time'):
                readers.add(file.name)
    assert readers == {'steady_clock.py'}
