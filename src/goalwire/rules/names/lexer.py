"""The lexemes of remap rules, parameter rules and log levels on the command line (rcl/lexer.h).

ROS 2's error messages quote the numbers of `Lexeme`.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

from goalwire.errors import LocalError
from goalwire.patterns import Pattern

if TYPE_CHECKING:
    from collections.abc import Container


class Lexeme(IntEnum):
    """Kinds of lexemes, numbered as rcl_lexeme_t."""

    NONE = 0
    EOF = 1
    TILDE_SLASH = 2
    URL_SERVICE = 3
    URL_TOPIC = 4
    COLON = 5
    NODE = 6
    NS = 7
    SEPARATOR = 8
    BACKREFERENCE = 9
    TOKEN = 18
    FORWARD_SLASH = 19
    WILD_ONE = 20
    WILD_MULTI = 21
    DOT = 22


class RuleSyntaxError(LocalError, ValueError):
    """An error for a rule on the command line that does not parse. The text is ROS 2's own.

    Programs get a different error, about arguments or a parameter file, which quotes this text.
    """


# The first pattern that matches wins. A token does not contain two underscores in a row.
_PATTERNS = {
    Lexeme.URL_SERVICE: r'rosservice://',
    Lexeme.URL_TOPIC: r'rostopic://',
    Lexeme.NODE: r'__(?:node|name)',
    Lexeme.NS: r'__ns',
    Lexeme.SEPARATOR: r':=',
    Lexeme.COLON: r':',
    Lexeme.TILDE_SLASH: r'~/',
    Lexeme.FORWARD_SLASH: r'/',
    Lexeme.DOT: r'\.',
    Lexeme.WILD_MULTI: r'\*\*',
    Lexeme.WILD_ONE: r'\*',
    Lexeme.BACKREFERENCE: r'\\[1-9]',
    Lexeme.TOKEN: r'(?!__)[A-Za-z_](?:[A-Za-z0-9]|(?<!_)_)*',
}
_NEXT = Pattern('|'.join(f'(?P<{lexeme.name}>{pattern})' for lexeme, pattern in _PATTERNS.items()))


class Lexer:
    """Reads `text` lexeme by lexeme. `index` is the start of the next lexeme."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.index = 0

    def peek(self) -> Lexeme:
        """Return the kind of the next lexeme."""
        return self._next()[0]

    def peek_two(self) -> tuple[Lexeme, Lexeme]:
        """Return the kinds of the next two lexemes."""
        first, end = self._next()
        start, self.index = self.index, end
        second = self.peek()
        self.index = start
        return first, second

    def accept(self, kinds: Container[Lexeme]) -> str:
        """If the next lexeme is of one of `kinds`, consume it and return its text; else return ''."""
        kind, end = self._next()
        if kind not in kinds:
            return ''
        text, self.index = self.text[self.index : end], end
        return text

    def expect(self, kind: Lexeme) -> str:
        """Consume the next lexeme and return its text; raises RuleSyntaxError if it is not of this `kind`."""
        found, end = self._next()
        if found is not kind:
            ended = found in {Lexeme.NONE, Lexeme.EOF}
            what = f'({kind:d}) not found, search ended' if ended else f'{kind:d}, got {found:d}'
            raise RuleSyntaxError(f'Expected lexeme type {what} at index {self.index}')
        text, self.index = self.text[self.index : end], end
        return text

    def rest(self) -> str:
        """Return the part of the text that has not been read."""
        return self.text[self.index :]

    def _next(self) -> tuple[Lexeme, int]:
        if self.index >= len(self.text):
            return Lexeme.EOF, self.index
        found = _NEXT.match(self.text, self.index)
        if found is None or found.lastgroup is None:
            return Lexeme.NONE, self.index
        return Lexeme[found.lastgroup], found.end()


def node_prefix(lexer: Lexer) -> str | None:
    """Consume the prefix `node:`, which limits a rule to one node, and return the node's name.

    Returns None if the text has no such prefix.
    """
    if lexer.peek_two() != (Lexeme.TOKEN, Lexeme.COLON):
        return None
    name = lexer.expect(Lexeme.TOKEN)
    lexer.expect(Lexeme.COLON)
    return name


def refuse_wildcard(lexer: Lexer) -> None:
    """Raise RuleSyntaxError if the next lexeme is a wildcard, which ROS 2 does not allow in rules."""
    if wildcard := lexer.accept({Lexeme.WILD_ONE, Lexeme.WILD_MULTI}):
        raise RuleSyntaxError(f"Wildcard '{wildcard}' is not implemented")
