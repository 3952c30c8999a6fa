"""Scripts of answers."""

from __future__ import annotations

from typing import Any

import pytest

from goalwire.testing.answers import NEVER, After, Script, after

WRONG: Any = 2.5


def test_one_answer_serves_for_ever() -> None:
    script: Script[int] = Script(7, int)
    assert [script.next() for _ in range(3)] == [7, 7, 7]


def test_a_list_is_used_up() -> None:
    script: Script[int] = Script([1, NEVER, after(2.0, 3)], int)
    assert [script.next() for _ in range(3)] == [1, NEVER, after(2.0, 3)]
    with pytest.raises(AssertionError, match='call 4 came, and there are 3 answers'):
        script.next()


@pytest.mark.parametrize('wrong', [WRONG, [1, WRONG], After(1.0, After(1.0, WRONG))])
def test_what_is_no_answer_is_refused_when_the_script_is_made(wrong: Any) -> None:
    with pytest.raises(TypeError, match=r'an answer is a int, a function, .* not 2\.5'):
        Script(wrong, int)
