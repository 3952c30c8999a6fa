"""Text of unknown length and origin, made fit for a line of a log or of a terminal."""

from __future__ import annotations

import argparse
import math
import shutil
from textwrap import fill

LONGEST = 400  # characters of a reason
LONGEST_NAME = 60  # characters shown of a name that comes from outside


def brief(text: str, longest: int = LONGEST) -> str:
    """Return the text; if it has more than `longest` characters, only its beginning and its end."""
    if len(text) <= longest:
        return text
    half = longest // 2
    return f'{text[:half]} … {text[-half:]} ({len(text)} characters)'


def quoted(text: str) -> str:
    """Return the text in quotes, with control characters escaped, shortened if it is long."""
    return repr(brief(text, LONGEST_NAME))


def finite(text: str) -> float:
    """Return the number of an option of the command line. Raises argparse.ArgumentTypeError."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f'{quoted(text)} is not a finite number')
    return number


def columns() -> int:
    """Return how many characters a line may have: by COLUMNS, else by the terminal, else 80."""
    return shutil.get_terminal_size((80, 24)).columns


def indented(text: str) -> str:
    """Return the text in lines of at most `columns()` characters; all but the first are indented."""
    start = len(text) - len(text.lstrip())
    return fill(text, max(columns(), 20), subsequent_indent=' ' * (start + 4), break_on_hyphens=False)
