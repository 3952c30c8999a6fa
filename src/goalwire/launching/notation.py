r"""The notation of substitutions in XML and YAML: `$(name argument …)` within any text.

A text has plain characters, characters escaped by `\`, and substitutions. Arguments are separated by spaces;
an argument in single or double quotes may have spaces and parentheses in it. Arguments are texts themselves,
so substitutions may be nested. The grammar is the same as in ROS 2's launch.
"""

from __future__ import annotations

import re
from typing import Any

from goalwire.errors import BadLaunchValueError, LaunchError
from goalwire.launching.exposure import instantiate_substitution
from goalwire.launching.model import SomeSubstitutions, Substitution
from goalwire.launching.values import TextSubstitution

_NAME = re.compile(r'[A-Za-z][A-Za-z0-9_-]*')


def replace_escaped_characters(data: str) -> str:
    r"""Return the text with each `\x` replaced by x."""
    return re.sub(r'\\(.)', r'\1', data)


def parse_substitution(string_value: str) -> list[Substitution]:
    """Parse a text into substitutions. Raises LaunchError for a malformed text or an unknown substitution."""
    reader = _Reader(string_value)
    parts = reader.text(end='')
    return parts or [TextSubstitution(text='')]


def parse_if_substitutions(value: Any) -> Any:
    """Parse a text with $(…) into substitutions, a list item by item. Return other values unchanged."""
    if isinstance(value, list):
        kinds = {type(item) for item in value} - {str}
        if len(kinds) > 1:
            raise BadLaunchValueError(f'{value!r:.100} is a list of different types')
        return [parse_if_substitutions(item) for item in value]
    if not isinstance(value, str):
        return value
    parts = parse_substitution(value)
    if len(parts) == 1 and isinstance(parts[0], TextSubstitution):
        return parts[0].text
    return parts


class _Reader:
    """Reads one text from left to right."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0

    def text(self, end: str) -> list[Substitution]:
        """Read up to the first character that is in `end`, without it; read everything if `end` is empty."""
        parts: list[Substitution] = []
        plain = ''
        while self._at < len(self._text):
            character = self._text[self._at]
            if character in end:
                break
            if self._text.startswith('$(', self._at):
                if plain:
                    parts.append(TextSubstitution(text=plain))
                    plain = ''
                parts.append(self._substitution())
                continue
            if character == '\\' and self._at + 1 < len(self._text):
                self._at += 1
                character = self._text[self._at]
            plain += character
            self._at += 1
        if plain:
            parts.append(TextSubstitution(text=plain))
        return parts

    def _substitution(self) -> Substitution:
        begin = self._at
        self._at += 2
        name = _NAME.match(self._text, self._at)
        if name is None:
            raise self._error('a name is missing after $(')
        self._at = name.end()
        arguments: list[SomeSubstitutions] = []
        while True:
            spaces = self._skip_spaces()
            if self._at >= len(self._text):
                raise self._error(f'no ) ends {self._text[begin : begin + 40]}')
            if self._text[self._at] == ')':
                self._at += 1
                return instantiate_substitution(name.group(), arguments)
            if not spaces:
                raise self._error(f'a space is missing before {self._text[self._at : self._at + 20]}')
            arguments.append(self._argument())

    def _argument(self) -> list[Substitution]:
        quote = self._text[self._at]
        if quote not in '\'"':
            return self.text(end=' )\t\n')
        self._at += 1
        found = self.text(end=quote)
        if self._at >= len(self._text):
            raise self._error(f'no {quote} ends the quotation')
        self._at += 1
        return found or [TextSubstitution(text='')]

    def _skip_spaces(self) -> bool:
        begin = self._at
        while self._at < len(self._text) and self._text[self._at].isspace():
            self._at += 1
        return self._at > begin

    def _error(self, what: str) -> LaunchError:
        return LaunchError(f"cannot read '{self._text}': {what}")
