"""Finds the places of items in a text of TOML: Python's reader gives only their values.

It goes through a text that tomllib has read before, so it need not find mistakes. Tables in braces are passed
over: their items get the place at which the table begins.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from goalwire.patterns import Pattern


class Place(NamedTuple):
    """A line and a column of a text, both from 1 on."""

    line: int
    column: int


_TOKEN = Pattern(
    r"""(?P<comment>\#[^\n]*)
      | (?P<text>\"{3}(?:\\.|[^\\])*?\"{3}|'{3}.*?'{3}|"(?:\\.|[^"\\\n])*"|'[^'\n]*')
      | (?P<bare>[A-Za-z0-9_+:.-]+)
      | (?P<sign>[\[\]{}=,\n])""",
    re.VERBOSE | re.DOTALL,
)


def find_places(text: str) -> dict[tuple[str | int, ...], Place]:
    """Return the places of tables, keys, and elements of lists, by their paths."""
    return _Finder(text).places


class _Finder:
    """Goes through one text, token by token."""

    def __init__(self, text: str) -> None:
        self.places: dict[tuple[str | int, ...], Place] = {}
        self._text = text
        self._tokens = [each for each in _TOKEN.finditer(text) if each.lastgroup != 'comment']
        self._table: tuple[str, ...] = ()
        at = 0
        while at < len(self._tokens):
            at = self._take_line(at)

    def _place(self, at: int) -> Place:
        start = self._tokens[at].start()
        line_start = self._text.rfind('\n', 0, start) + 1
        return Place(self._text.count('\n', 0, start) + 1, start - line_start + 1)

    def _take_line(self, at: int) -> int:
        """Read a table's header, a key with its value, or an empty line; return the position of the next
        line.
        """
        sign = self._tokens[at].group()
        if sign == '\n':
            return at + 1
        if sign == '[':
            path, end = self._key(at + 1)
            self._table = path
            self._note(path, 1, at)
            while end < len(self._tokens) and self._tokens[end].group() != '\n':
                end += 1
            return end
        path, end = self._key(at)
        path = (*self._table, *path)
        self._note(path, len(self._table) + 1, at)
        return self._take_value(path, end + 1)

    def _note(self, path: tuple[str, ...], shortest: int, at: int) -> None:
        """Take note of a key, and of the tables that it is in, if they have not been seen before."""
        for size in range(shortest, len(path) + 1):
            self.places.setdefault(path[:size], self._place(at))

    def _key(self, at: int) -> tuple[tuple[str, ...], int]:
        """Return the dotted key that begins here, and the position behind it."""
        parts: list[str] = []
        while at < len(self._tokens) and self._tokens[at].lastgroup in {'text', 'bare'}:
            word = self._tokens[at].group()
            if self._tokens[at].lastgroup == 'text':
                parts.append(word[1:-1])
            else:
                parts += filter(None, word.split('.'))
            at += 1
        return tuple(parts), at

    def _take_value(self, path: tuple[str, ...], at: int) -> int:
        """Note the elements of a list; return the position behind the value."""
        depth = element = 0
        while at < len(self._tokens):
            sign = self._tokens[at].group()
            if sign == '\n' and not depth:
                break
            if sign in {'[', '{'}:
                depth += 1
            elif sign in {']', '}'}:
                depth -= 1
            elif sign == ',' and depth == 1:
                element += 1
            elif sign != '\n' and depth == 1:
                self.places.setdefault((*path, element), self._place(at))
            at += 1
        return at
