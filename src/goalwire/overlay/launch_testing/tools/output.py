"""launch_testing.tools.output: filters output, and compares it with expected output."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from launch_testing.matching import build_line_match, build_text_match, remove_ansi_escape_sequences


def get_default_filtered_prefixes() -> list[str]:
    """Return the prefixes of lines about process ids and exit codes, which tests ignore."""
    return ['pid', 'rc']


def get_default_filtered_patterns() -> list[str]:
    """Return the patterns of lines that tests ignore by default: an empty list."""
    return []


def basic_output_filter(
    filtered_prefixes: Iterable[str] | None = None, filtered_patterns: Iterable[str] | None = None
) -> Callable[[str], str]:
    """Return a function that drops lines that have one of the prefixes or match one of the patterns."""
    prefixes = tuple(get_default_filtered_prefixes() if filtered_prefixes is None else filtered_prefixes)
    texts = get_default_filtered_patterns() if filtered_patterns is None else filtered_patterns
    patterns = [re.compile(text) for text in texts]

    def drop_lines(output: str) -> str:
        lines = output.splitlines(keepends=True)
        return ''.join(
            line
            for line in lines
            if not line.startswith(prefixes) and not any(pattern.match(line) for pattern in patterns)
        )

    return drop_lines


def expected_output_from_file(path: str, encoding: str | None = None) -> list[Any]:
    """Return the lines of the file PATH.txt, else the patterns in PATH.regex.

    Raises RuntimeError without either.
    """
    texts, patterns = Path(f'{path}.txt'), Path(f'{path}.regex')
    if texts.is_file():
        return list(texts.read_text(encoding=encoding).splitlines())
    if patterns.is_file():
        return [re.compile(line) for line in patterns.read_text(encoding=encoding).splitlines()]
    raise RuntimeError(f'could not find output check file: {path}')


def expect_output(
    text: str | None = None,
    *,
    lines: Sequence[str] | None = None,
    expected_text: Any = None,
    expected_lines: Any = None,
    strip_ansi_escape_sequences: bool = True,
    strict: bool = False,
) -> bool:
    """Return whether a text or lines match the expectation.

    Raises ValueError if both a text and lines are given.
    """
    if (text is not None) == (lines is not None):
        raise ValueError('Either lines or text, but not both, must be specified')
    if (expected_text is not None) == (expected_lines is not None):
        raise ValueError('Either expected lines or text, but not both, must be specified')
    whole = text if text is not None else '\n'.join(lines or ())
    if strip_ansi_escape_sequences:
        whole = remove_ansi_escape_sequences(whole)
    if expected_text is not None:
        return build_text_match(expected_text, strict=strict)(whole) is not None
    return build_line_match(expected_lines, strict=strict)(whole.splitlines()) is not None
