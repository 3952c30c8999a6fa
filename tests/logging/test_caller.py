from __future__ import annotations

import sys
from pathlib import Path

from goalwire.logging import CallerId


def test_a_caller_id_names_function_file_and_line_of_whoever_makes_it() -> None:
    caller = CallerId()
    assert caller.function_name == 'test_a_caller_id_names_function_file_and_line_of_whoever_makes_it'
    assert Path(caller.file_path) == Path(__file__)
    assert 'caller = CallerId()' in Path(__file__).read_text().splitlines()[caller.line_number - 1]


def test_two_calls_in_one_line_differ() -> None:
    first, second = CallerId(), CallerId()
    assert first.line_number == second.line_number
    assert first != second


def test_the_same_call_is_equal_each_time() -> None:
    assert len({CallerId() for _ in range(3)}) == 1


def test_a_frame_may_be_given() -> None:
    assert CallerId(sys._getframe(0)).function_name == 'test_a_frame_may_be_given'


def test_a_relative_file_name_is_made_absolute() -> None:
    names: dict[str, CallerId] = {}
    exec(compile('caller = CallerId()', 'typed_in', 'exec'), {'CallerId': CallerId}, names)
    assert Path(names['caller'].file_path) == Path.cwd() / 'typed_in'
