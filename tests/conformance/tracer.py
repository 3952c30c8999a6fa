"""Runs a plain rclpy program one statement after the other and tells what each of them gave.

`python tracer.py PROGRAM TRACE` writes a JSON line to the file TRACE for every expression that stands alone:
the `call` as it is written, and what it `gives`, or what it `raises` (class names, most derived first) with
which `text`. An exception ends its own statement only, so that two implementations of rclpy tell of the same
calls in the same order. What a statement prints is told too. Any rclpy may be importable.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

_SUBSTITUTES = [
    (re.compile(r', at [^,\s]+\.(?:c|cpp|h|hpp):\d+'), ''),  # where in the C library
    (re.compile(r'<(class|enum) \'(?:\w+\.)*(\w+)\'>'), r'<\1 \2>'),  # modules differ, names must not
    (re.compile(r'<(?:\w+\.)*(\w+) object at 0x[0-9a-f]+>'), r'<\1>'),
    (re.compile(r' at 0x[0-9a-f]+'), ''),
]


def plain(text: str) -> str:
    """Return `text` without what changes from run to run, or tells where a class was made."""
    for pattern, substitute in _SUBSTITUTES:
        text = pattern.sub(substitute, text)
    return text


def outcome_of(statement: ast.stmt, names: dict[str, Any]) -> dict[str, Any]:
    """Run one statement; return what is to be told of it, nothing for one that merely succeeds."""
    printed = io.StringIO()
    outcome: dict[str, Any] = {}
    try:
        with contextlib.redirect_stdout(printed):
            if isinstance(statement, ast.Expr):
                expression = compile(ast.Expression(statement.value), '<call>', 'eval')
                outcome['gives'] = plain(repr(eval(expression, names)))
            else:
                exec(compile(ast.Module([statement], []), '<statement>', 'exec'), names)
    except BaseException as error:  # whatever it is, it is what the call did
        outcome['raises'] = [kind.__name__ for kind in type(error).__mro__[:-1]]
        outcome['text'] = plain(str(error))
    if printed.getvalue():
        outcome['printed'] = plain(printed.getvalue())
    return outcome


def told(source: str, names: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Run a program's text and yield what to tell; it begins with a docstring."""
    for statement in ast.parse(source).body[1:]:
        if outcome := outcome_of(statement, names):
            yield {'call': ast.get_source_segment(source, statement), **outcome}


def main(program: str, trace: str) -> None:
    """Run `program` and write its trace, line by line, so that a program that dies has told until then."""
    sys.argv = [program]
    names = {'__name__': '__main__', '__file__': program}
    with Path(trace).open('w', encoding='utf-8', buffering=1) as lines:
        source = Path(program).read_text(encoding='utf-8')
        lines.writelines(f'{json.dumps(line)}\n' for line in told(source, names))


if __name__ == '__main__':
    main(*sys.argv[1:])
