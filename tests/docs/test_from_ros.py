"""Each request of the table has the test that it names."""

from __future__ import annotations

import pytest
from helpers.markdown import DOCS, ROOT, rows

ASKED = rows(DOCS / 'from-ros' / 'index.md', 'what')


def test_the_table_is_not_short() -> None:
    assert len(ASKED) >= 25


@pytest.mark.parametrize(('what', 'test'), [(what, test) for what, _, test in ASKED])
def test_a_request_is_answered_by_a_test_that_exists(what: str, test: str) -> None:
    path, name = test.strip('`').split('::')
    assert f'def {name}(' in (ROOT / path).read_text(encoding='utf-8'), what
