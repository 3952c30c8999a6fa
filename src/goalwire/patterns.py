"""Regular expressions that are compiled at their first use.

To compile one takes 0.1 to 4 ms, as much as to import some modules. Most programs use few of those that the
modules of their start define: together they were a tenth of the start.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

_METHODS = ('findall', 'finditer', 'fullmatch', 'match', 'search', 'sub')


class Pattern:
    """A regular expression with the methods of `re.Pattern`; the first use compiles it."""

    findall: Callable[..., list[Any]]  # texts, or tuples of them
    finditer: Callable[..., Iterator[re.Match[str]]]
    fullmatch: Callable[..., re.Match[str] | None]
    match: Callable[..., re.Match[str] | None]
    search: Callable[..., re.Match[str] | None]
    sub: Callable[..., str]

    def __init__(self, text: str, flags: int = 0) -> None:
        self._text = text
        self._flags = flags

    def __getattr__(self, name: str) -> object:  # asked for a method that is not there yet
        if name not in _METHODS:
            raise AttributeError(name)
        compiled = re.compile(self._text, self._flags)
        for method in _METHODS:
            setattr(self, method, getattr(compiled, method))
        return getattr(compiled, name)
