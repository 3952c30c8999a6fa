"""The output of a command. Everything that came from a peer is escaped here, on its way to the terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TextIO

from goalwire.errors import peer_text

if TYPE_CHECKING:
    from typing import TypeAlias

    Json: TypeAlias = 'Mapping[str, Json] | Sequence[Json] | str | float | bool | None'

_WITHOUT_LIMIT = sys.maxsize - 1
STATUS_STYLES = {
    'EXECUTING': 'cyan',
    'SUCCEEDED': 'green',
    'ABORTED': 'red',
    'CANCELED': 'yellow',
    'CANCELING': 'yellow',
}
"""The style of a goal, by its status."""
STYLES = {'bold': '1', 'dim': '2', 'red': '31', 'green': '32', 'yellow': '33', 'cyan': '36'}


def spell_out(text: str) -> str:
    """Return a text as one line for a terminal; a line break is spelt out, so that no name forges lines."""
    return text if text.isprintable() else peer_text(text, _WITHOUT_LIMIT)


def escape(text: str) -> str:
    r"""Return a text that is safe for a terminal: all control characters except \n and \t are spelt out."""
    if text.isprintable():
        return text
    return '\n'.join(
        line
        if line.isprintable()
        else '\t'.join(peer_text(part, _WITHOUT_LIMIT) for part in line.split('\t'))
        for line in text.split('\n')
    )


class Output:
    """Standard output: text for people, or with `--json` one JSON document a line."""

    def __init__(self, stream: TextIO | None = None, *, json: bool = False) -> None:
        self._stream = sys.stdout if stream is None else stream
        self.json = json
        self.is_terminal = self._stream.isatty()
        self._coloured = (
            self.is_terminal and not os.environ.get('NO_COLOR') and os.environ.get('TERM') != 'dumb'
        )

    def line(self, text: str = '', *, style: str = '') -> None:
        """Print one line; see `spell_out`."""
        self._stream.write(f'{self.style(spell_out(text), style)}\n')

    def block(self, text: str, *, end: str = '\n') -> None:
        """Print a text of several lines, and flush."""
        self._stream.write(escape(text) + end)
        self._stream.flush()

    def data(self, value: Json) -> None:
        """Print one JSON document on a line of its own, and flush."""
        self._stream.write(json_text(value) + '\n')
        self._stream.flush()

    def show(self, value: Json, text: str, *, style: str = '') -> None:
        """Print the value with `--json`, else the text on one line."""
        if self.json:
            self.data(value)
        else:
            self.line(text, style=style)

    def style(self, text: str, style: str) -> str:
        """Return a text in a style of STYLES, only on a terminal."""
        return f'\x1b[{STYLES[style]}m{text}\x1b[0m' if style and self._coloured else text

    def rewrite(self, text: str) -> None:
        """Replace the line that the cursor is on; only for terminals."""
        self._stream.write(f'\r{escape(text)}\x1b[K')
        self._stream.flush()

    def raw(self, text: str) -> None:
        """Print a text that controls the terminal; the parts from peers are escaped already."""
        self._stream.write(text)
        self._stream.flush()

    def flush(self) -> None:
        """Flush everything that was printed."""
        self._stream.flush()


def json_text(value: Json) -> str:
    """Return JSON on one line. Numbers that JSON lacks are spelt 'NaN', 'Infinity', '-Infinity'."""
    import json

    try:
        text = json.dumps(value, ensure_ascii=False, allow_nan=False, default=_plain)
    except ValueError:
        text = json.dumps(_without_nan(value), ensure_ascii=False, default=_plain)
    if text.isprintable():
        return text
    return ''.join(char if char.isprintable() else _json_escape(char) for char in text)


def _json_escape(char: str) -> str:
    units = char.encode('utf-16-be', 'surrogatepass').hex()
    return ''.join(f'\\u{units[at : at + 4]}' for at in range(0, len(units), 4))


def _plain(value: object) -> Json:
    if isinstance(value, bytes):
        return value.hex()
    return str(value)


def _without_nan(value: Json) -> Json:
    if isinstance(value, float) and (value != value or value in {float('inf'), float('-inf')}):  # noqa: PLR0124
        return {'nan': 'NaN', 'inf': 'Infinity', '-inf': '-Infinity'}[str(value)]
    if isinstance(value, Mapping):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(item) for item in value]
    return value


def tell(text: str) -> None:
    """Print progress on standard error: it is not a result, and not part of `--json`."""
    sys.stderr.write(escape(text) + '\n')
    sys.stderr.flush()
