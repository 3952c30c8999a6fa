"""The functions of launch_testing.tools.text: they look for expected text or lines.

They are in a separate module because the assertions use them, and `launch_testing.tools` uses the assertions.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias

from goalwire.patterns import Pattern

Span: TypeAlias = tuple[int, int]
_ESCAPES = Pattern(r'\x1b(\[[0-?]*[ -/]*[@-~]|[@-Z\\-_])')


def normalize_lineseps(lines: str) -> str:
    r"""Return the text with all line ends replaced by \n."""
    return lines.replace(os.linesep, '\n').replace('\r\n', '\n')


def remove_ansi_escape_sequences(text: str) -> str:
    """Return the text without its escape sequences for a terminal."""
    return _ESCAPES.sub('', text)


def build_text_match(expected_text: Any, *, strict: bool = False) -> Callable[..., Span | None]:
    """Return a function that finds a text, a compiled pattern, or several of them in order.

    The function takes a text and a start, and returns (begin, end) of the match, or None.
    Raises ValueError if the expected text is of another type.
    """
    if isinstance(expected_text, str):
        return lambda actual_text, start=0: _find(
            normalize_lineseps(actual_text), start, expected_text, strict=strict
        )
    if isinstance(expected_text, re.Pattern):

        def match_pattern(actual_text: str, start: int = 0) -> Span | None:
            look = expected_text.match if strict else expected_text.search
            found = look(normalize_lineseps(actual_text), start)
            return None if found is None else found.span()

        return match_pattern
    if isinstance(expected_text, Iterable):
        return _in_order([build_text_match(each) for each in expected_text], strict=strict)
    raise ValueError('Unknown format for expected text')


def build_line_match(expected_lines: Any, *, strict: bool = False) -> Callable[..., Span | None]:
    """Return a function that finds a line by its text or a compiled pattern, or several lines in order.

    The function takes lines and a start, and returns (begin, end) of the match, or None.
    Raises ValueError if the expected lines are of another type.
    """
    if isinstance(expected_lines, str | re.Pattern):

        def fits(line: str) -> bool:
            if isinstance(expected_lines, str):
                return line == expected_lines if strict else expected_lines in line
            return expected_lines.match(line) is not None

        def match_line(actual_lines: Sequence[str], start: int = 0) -> Span | None:
            if strict:
                return (start, len(actual_lines)) if all(map(fits, actual_lines[start:])) else None
            found = (index for index in range(start, len(actual_lines)) if fits(actual_lines[index]))
            return next(((index, index + 1) for index in found), None)

        return match_line
    if isinstance(expected_lines, Iterable):
        return _in_order([build_line_match(each) for each in expected_lines], strict=strict)
    raise ValueError('Unknown format for expected lines')


def _find(text: str, start: int, wanted: str, *, strict: bool) -> Span | None:
    if strict:
        return (start, start + len(wanted)) if text[start:] == wanted else None
    found = text.find(wanted, start)
    return None if found < 0 else (found, found + len(wanted))


def _in_order(matches: Sequence[Callable[..., Span | None]], *, strict: bool) -> Callable[..., Span | None]:
    """Return a function that finds all patterns in order; with `strict`, gaps are not allowed."""

    def match_all(actual: Any, start: int = 0) -> Span | None:
        begin, end = -1, start
        for match in matches:
            found = match(actual, end)
            if found is None or (strict and found[0] != end):
                return None
            begin, end = (found[0] if begin < 0 else begin), found[1]
        return begin, end

    return match_all
