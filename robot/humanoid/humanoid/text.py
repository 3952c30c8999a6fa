"""Text of unknown length and origin, made fit for a line of a log."""

from __future__ import annotations

LONGEST = 400  # characters of a reason
LONGEST_NAME = 60  # characters of a name that is not one of ours


def brief(text: str, longest: int = LONGEST) -> str:
    """The text, or its beginning and its end where it has more than `longest` characters."""
    if len(text) <= longest:
        return text
    half = longest // 2
    return f'{text[:half]} … {text[-half:]} ({len(text)} characters)'


def quoted(text: str) -> str:
    """The text in quotes, its control characters escaped, of bounded length."""
    return repr(brief(text, LONGEST_NAME))
