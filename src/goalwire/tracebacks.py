"""Formats exceptions for logs and terminals: with the program's own frames, without the library's.

Frames of files inside the goalwire package are left out if others remain. The text says how many, and
`GOALWIRE_FULL_TRACEBACKS=1` shows all. Texts of exceptions may quote what a peer sent. So their control
characters are escaped, and their second and later lines are indented: none can pass for a line of the log.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

from goalwire.errors import peer_text
from goalwire.hints import hint_for

if TYPE_CHECKING:
    from traceback import FrameSummary, StackSummary, TracebackException
    from types import TracebackType

VARIABLE = 'GOALWIRE_FULL_TRACEBACKS'

_LIBRARY = os.path.dirname(os.path.abspath(__file__)) + os.sep  # noqa: PTH100, PTH120
_GENERATED = '<goalwire'
_STANDARD = os.path.dirname(os.__file__) + os.sep  # noqa: PTH120
_INSTALLED = tuple(os.path.join(_STANDARD, folder) for folder in ('site-packages', 'dist-packages'))  # noqa: PTH118
_LINE_LIMIT = 5000


def show_uncaught(error: BaseException, title: str = '') -> None:
    """Print what ends a program or a thread, in one piece: other threads log meanwhile."""
    if sys.stderr is None:
        return
    try:
        sys.stderr.write(f'{title}{traceback_text(error)}\n')
        sys.stderr.flush()
    except UnicodeEncodeError:
        sys.__excepthook__(type(error), error, error.__traceback__)


def hide_own_frames() -> None:
    """Have Python show uncaught errors without the library's frames, where nobody else has a say in that.

    For errors before `rclpy.init`, which installs more: a definition that cannot be imported, say.
    """
    if sys.excepthook is sys.__excepthook__:
        sys.excepthook = excepthook


def excepthook(_kind: type[BaseException], error: BaseException, _traceback: TracebackType | None) -> None:
    """Print an error that was not caught."""
    show_uncaught(error)


def traceback_text(error: BaseException) -> str:
    """Return the lines of an exception and of its causes, without the last line break."""
    from traceback import TracebackException  # heavy, and needed only when something has failed

    told = TracebackException.from_exception(error)
    hidden = 0 if os.environ.get(VARIABLE) == '1' else _hide_library(told, set())
    text = ''.join(_safe(chunk) for chunk in told.format()).rstrip()
    if hidden:
        frames = 'frame of goalwire is' if hidden == 1 else 'frames of goalwire are'
        first, _, rest = text.partition('\n')  # the last line still names the error
        text = f'{first}\n  ({hidden} {frames} not shown: {VARIABLE}=1 shows them)\n{rest}'
    hint = hint_for(error)
    return f'{text}\n  {hint}' if hint else text


def is_library(filename: str) -> bool:
    """Whether a frame of this file is the library's own."""
    return filename.startswith((_LIBRARY, _GENERATED))


def is_standard(filename: str) -> bool:
    """Whether a frame of this file is Python's own."""
    return filename.startswith(('<frozen ', _STANDARD)) and not filename.startswith(_INSTALLED)


def _hide_library(told: TracebackException, seen: set[int]) -> int:
    """Take the library's frames out of an exception, its causes and its parts; return how many."""
    if id(told) in seen:
        return 0
    seen.add(id(told))
    hidden = _hide_frames(told.stack)
    for other in (told.__cause__, told.__context__, *(told.exceptions or ())):
        if other is not None:
            hidden += _hide_library(other, seen)
    return hidden


def _hide_frames(stack: StackSummary) -> int:
    """Remove the library's frames, and Python's own that it calls; the program's frames stay."""
    shown: list[FrameSummary] = []
    within = False
    for frame in stack:
        within = is_library(frame.filename) or (within and is_standard(frame.filename))
        if not within:
            shown.append(frame)
    if all(is_standard(frame.filename) for frame in shown):
        return 0  # no frame of the program is left
    hidden = len(stack) - len(shown)
    stack[:] = shown
    return hidden


def _safe(chunk: str) -> str:
    """Return a piece of a traceback in which no text of an exception begins a line or steers a terminal."""
    if chunk.startswith('\n'):  # Python's own words between two exceptions
        return chunk
    first, *rest = chunk.removesuffix('\n').split('\n')
    lines = [first, *(line if line.startswith(' ') or not line else f'  {line}' for line in rest)]
    return '\n'.join(peer_text(line, _LINE_LIMIT) for line in lines) + '\n'
