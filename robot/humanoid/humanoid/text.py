"""Makes text of unknown length and origin fit for a line in a log or on a terminal."""

from __future__ import annotations

import argparse
import math
import shutil
from textwrap import fill

LONGEST = 400  # characters that a text may have by default
LONGEST_NAME = 60  # characters shown of a name from users or messages


def brief(text: str, longest: int = LONGEST) -> str:
    """Return the text; of a text with more than `longest` characters, only its beginning and its end."""
    if len(text) <= longest:
        return text
    half = longest // 2
    return f'{text[:half]} … {text[-half:]} ({len(text)} characters)'


def quote(text: str) -> str:
    """Return the text in quotes, with control characters escaped, shortened if it is long."""
    return repr(brief(text, LONGEST_NAME))


def finite(text: str) -> float:
    """Convert an option's text to a finite number. Raises argparse.ArgumentTypeError."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f'{quote(text)} is not a finite number')
    return number


def columns() -> int:
    """Return how many characters a line may have: the variable COLUMNS, the terminal's width, or 80."""
    return shutil.get_terminal_size((80, 24)).columns


def indent(text: str) -> str:
    """Return the text in lines of at most `columns()` characters; all lines but the first are indented."""
    start = len(text) - len(text.lstrip())
    return fill(text, max(columns(), 20), subsequent_indent=' ' * (start + 4), break_on_hyphens=False)
