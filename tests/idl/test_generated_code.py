"""Generated code: its lines are in tracebacks, and cost nothing until then."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path
from typing import cast

from helpers.fresh import output_of

from goalwire.idl.generated_code import run_source


def test_a_traceback_shows_the_line_that_failed() -> None:
    names: dict[str, object] = {}
    run_source('def divide(number):\n    return number / 0  # a line of its own\n', names, 'test of lines')
    try:
        cast('Callable[[int], float]', names['divide'])(1)
    except ZeroDivisionError:
        shown = traceback.format_exc()
    assert 'File "<goalwire test of lines>.py", line 2, in divide' in shown
    assert 'return number / 0  # a line of its own' in shown


def test_a_message_is_made_and_encoded_without_what_tracebacks_need(tmp_path: Path) -> None:
    program = """\
        import sys

        before = set(sys.modules)  # Python 3.13 keeps the lines of a program after -c
        from rclpy.serialization import serialize_message
        from std_msgs.msg import String

        serialize_message(String(data='x'))
        print({'linecache', 'tokenize', 'traceback'} & (set(sys.modules) - before))
    """
    assert output_of(program, cwd=tmp_path) == 'set()'
