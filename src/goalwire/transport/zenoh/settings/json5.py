"""JSON5, the format of Zenoh's configuration files and overrides (https://spec.json5.org).

JSON with comments, trailing commas, names without quotes, texts in single quotes, and more ways to write a
number. The line of each value is kept, so that errors can name it.
"""

from __future__ import annotations

import re
from typing import NamedTuple, NoReturn

from goalwire.patterns import Pattern
from goalwire.transport.zenoh.settings.values import Json

DEEPEST = 100
"""How deep objects and lists may be nested."""

_TOKEN = Pattern(
    r"""(?P<space>(?:[\s\ufeff]|//[^\n\r\u2028\u2029]*|/\*.*?\*/)+)
    |(?P<text>"(?:[^"\\\n\r]|\\.)*"|'(?:[^'\\\n\r]|\\.)*')
    |(?P<number>[+-]?(?:0[xX][0-9a-fA-F]+|(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?
        |Infinity\b|NaN\b))(?![\w$.])
    |(?P<name>[^\W\d][\w$]*|\$[\w$]*)
    |(?P<sign>[{}\[\]:,])""",
    re.VERBOSE | re.DOTALL,
)
_ESCAPE = Pattern(r'\\(?:u([0-9a-fA-F]{4})|x([0-9a-fA-F]{2})|(\r\n|.))', re.DOTALL)
_ESCAPED = {'b': '\b', 'f': '\f', 'n': '\n', 'r': '\r', 't': '\t', 'v': '\v', '0': '\0'} | dict.fromkeys(
    ('\n', '\r', '\r\n', '\u2028', '\u2029'), ''
)
_WORDS: dict[str, Json] = {'true': True, 'false': False, 'null': None}
_END = ''


class Json5Error(Exception):
    """The error for a text that is not JSON5, with the position and the mistake.

    It becomes a TransportError or a warning.
    """


class Document(NamedTuple):
    """The value that a text holds, and the lines of its settings."""

    value: Json
    lines: dict[str, int]
    """The line of each value by its path, such as 'connect/endpoints'. A list counts as one value."""


def read(text: str) -> Document:
    """Read a text. Raises Json5Error."""
    return _Reader(text).document()


class _Reader:
    """Reads one text from its beginning to its end."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._start = 0
        """The position of the current token."""
        self._kind = ''
        self._word = ''
        self._lines: dict[str, int] = {}
        self._line, self._counted = 1, 0
        self._depth = 0

    def document(self) -> Document:
        self._advance()
        value = self._value('')
        if self._word != _END or self._kind:
            self._refuse('the end of the text')
        return Document(value, self._lines)

    def _advance(self) -> None:
        """Go to the next token."""
        while True:
            self._start = self._at
            if self._at == len(self._text):
                self._kind = self._word = _END
                return
            found = _TOKEN.match(self._text, self._at)
            if found is None:
                self._fail(self._unreadable())
            self._at = found.end()
            if found.lastgroup != 'space':
                self._kind, self._word = str(found.lastgroup), found.group()
                return

    def _unreadable(self) -> str:
        rest = self._text[self._at : self._at + 2]
        if rest == '/*':
            return "a comment '/*' has no end"
        if rest[0] in '"\'':
            return f'a text that begins with {rest[0]} has no end on its line'
        return f'{rest[0]!r} cannot be read here'

    def _value(self, path: str) -> Json:
        word, kind = self._word, self._kind
        if path:
            self._lines.setdefault(path, self._current_line())
        if word in ('{', '[') and kind == 'sign':
            self._depth += 1
            if self._depth > DEEPEST:
                self._fail(f'more than {DEEPEST} objects and lists lie within each other')
            value = self._object(path) if word == '{' else self._list(path)
            self._depth -= 1
            return value
        if kind == 'text':
            result: Json = self._unescape(word)
        elif kind == 'number':
            result = _number(word)
        elif kind == 'name' and word in _WORDS:
            result = _WORDS[word]
        else:
            self._refuse('a value')
        self._advance()
        return result

    def _object(self, path: str) -> Json:
        self._advance()
        found: dict[str, Json] = {}
        while self._word != '}' or self._kind != 'sign':
            if self._kind == 'text':
                name = self._unescape(self._word)
            elif self._kind == 'name' or self._word in {'Infinity', 'NaN'}:
                name = self._word
            else:
                self._refuse("a name or '}'")
            if name in found:
                self._fail(f"'{name}' is there twice")
            self._advance()
            if self._word != ':' or self._kind != 'sign':
                self._refuse(f"':' after '{name}'")
            self._advance()
            found[name] = self._value(f'{path}/{name}' if path else name)
            self._skip_comma('}')
        self._advance()
        return found

    def _list(self, path: str) -> Json:
        self._advance()
        found: list[Json] = []
        while self._word != ']' or self._kind != 'sign':
            found.append(self._value(path))
            self._skip_comma(']')
        self._advance()
        return found

    def _skip_comma(self, end: str) -> None:
        if self._kind == 'sign' and self._word == ',':
            self._advance()
        elif self._kind != 'sign' or self._word != end:
            self._refuse(f"',' or '{end}'")

    def _unescape(self, token: str) -> str:
        if '\\' not in token:
            return token[1:-1]

        def replace(found: re.Match[str]) -> str:
            code = found[1] or found[2]
            if code:
                return chr(int(code, 16))
            if found[3] in 'ux' or (found[3].isdigit() and found[3] != '0'):
                self._fail(f"'{found[0]}' is not an escape")
            return _ESCAPED.get(found[3], found[3])

        text = _ESCAPE.sub(replace, token[1:-1])
        try:  # a surrogate pair: two halves of one character
            return text.encode('utf-16', 'surrogatepass').decode('utf-16')
        except UnicodeDecodeError:
            self._fail('a text holds half a character')

    def _current_line(self) -> int:
        self._line += self._text.count('\n', self._counted, self._start)
        self._counted = self._start
        return self._line

    def _refuse(self, what: str) -> NoReturn:
        found = f"not '{self._word[:40]}'" if self._kind else 'but the text ends'
        self._fail(f'{what} is expected, {found}')

    def _fail(self, why: str) -> NoReturn:
        line = self._text.count('\n', 0, self._start) + 1
        column = self._start - (self._text.rfind('\n', 0, self._start) + 1) + 1
        raise Json5Error(f'line {line}, column {column}: {why}')


def _number(token: str) -> Json:
    bare = token.lstrip('+-')
    sign = -1 if token[0] == '-' else 1
    if bare[:2] in {'0x', '0X'}:
        return sign * int(bare, 16)
    if bare.isdigit():
        # Python refuses to convert so many digits; no setting takes such a number.
        return sign * (int(bare) if len(bare) < 100 else float('inf'))
    return sign * float(bare.replace('Infinity', 'inf'))
