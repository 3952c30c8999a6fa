"""Regular expressions that are compiled at their first use.

Compiling an expression takes 0.1 to 4 ms, as long as some imports. Most programs use only a few of the
expressions that are defined in the modules they import: compiling all of them took a tenth of a program's
start.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

_METHODS = ('findall', 'finditer', 'fullmatch', 'match', 'search', 'sub')


class Pattern:
    """A regular expression with the methods of `re.Pattern`; the first use compiles it."""

    findall: Callable[..., list[Any]]  # of texts, or of tuples of texts
    finditer: Callable[..., Iterator[re.Match[str]]]
    fullmatch: Callable[..., re.Match[str] | None]
    match: Callable[..., re.Match[str] | None]
    search: Callable[..., re.Match[str] | None]
    sub: Callable[..., str]

    def __init__(self, text: str, flags: int = 0) -> None:
        self._text = text
        self._flags = flags

    def __getattr__(self, name: str) -> object:  # a method is used for the first time
        if name not in _METHODS:
            raise AttributeError(name)
        compiled = re.compile(self._text, self._flags)
        for method in _METHODS:
            setattr(self, method, getattr(compiled, method))
        return getattr(compiled, name)
