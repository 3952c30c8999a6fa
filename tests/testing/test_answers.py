"""Scripts of answers."""

from __future__ import annotations

import pytest

from goalwire.testing.answers import NEVER, Script, after


def test_one_answer_serves_for_ever() -> None:
    script: Script[int] = Script(7)
    assert [script.next() for _ in range(3)] == [7, 7, 7]


def test_a_list_is_used_up() -> None:
    script: Script[int] = Script([1, NEVER, after(2.0, 3)])
    assert [script.next() for _ in range(3)] == [1, NEVER, after(2.0, 3)]
    with pytest.raises(AssertionError, match='call 4 came, and there are 3 answers'):
        script.next()
