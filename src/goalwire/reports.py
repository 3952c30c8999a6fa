"""Counts and logs what goes wrong on a wire: each kind at each place at first, then at powers of ten.

A message that breaks the rules is rejected and counted. A receiver that raises is reported; the sender and
the transport's thread go on.
"""

from __future__ import annotations

import signal
from collections import Counter
from threading import Lock, current_thread, main_thread
from types import CodeType
from typing import Protocol

from goalwire.errors import peer_text

LOGGER = 'goalwire.transport'
"""The logger of what belongs to no node."""


class Origin(Protocol):
    """Where something arrived: an EndpointState, for one."""

    @property
    def title(self) -> str:
        """As logs show it: "service '/add'"."""

    @property
    def logger(self) -> str:
        """The logger for it: that of the node, so that the line reaches /rosout."""


class RejectCounters:
    """Counts per kind of fault and endpoint; safe from any thread."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._counts: Counter[tuple[str, str]] = Counter()

    def add(self, kind: str, reason: object, origin: Origin | None = None) -> None:
        """Count one; see `log_rejected` for which are logged. Without an origin it concerns the session."""
        title = '' if origin is None else origin.title
        count = self.count(kind, title)
        named = f'{"an" if kind[:1] in "aeiou" else "a"} {kind} was ignored'
        what = f'{title}: {named}' if title else named
        log_rejected(LOGGER if origin is None else origin.logger, what, count, reason)

    def count(self, kind: str, title: str) -> int:
        """Count one more of a kind at an endpoint, and return how many there are by now."""
        with self._lock:
            self._counts[kind, title] += 1
            return self._counts[kind, title]

    def counts(self) -> dict[str, int]:
        """Return the count of every kind seen, of all endpoints together."""
        totals: Counter[str] = Counter()
        with self._lock:
            for (kind, _), count in self._counts.items():
                totals[kind] += count
        return dict(totals)


def is_told(count: int) -> bool:
    """Whether the `count`th of one kind is logged: the first, and each power of ten."""
    return str(count).strip('0') == '1'


def log_rejected(logger: str, what: str, count: int, reason: object, *, is_error: bool = False) -> None:
    """Log the `count`th rejection of one kind at one place, where `is_told` says so."""
    if not is_told(count):
        return
    from goalwire.logging import LoggingSeverity, get_logger  # needed only when something is broken

    told = peer_text(reason)
    if count == 1:
        text = f'{what} ({told}); further ones are counted, and told of at 10, 100, 1000, …'
    else:
        text = f'{what}, {count} times by now; the last time: {told}'
    get_logger(logger).log(text, LoggingSeverity.ERROR if is_error else LoggingSeverity.WARN)


_PLACES_LIMIT = 1000
"""Places whose failures are told apart; beyond them nothing new is logged."""

_lock = Lock()
_failures: Counter[tuple[str, type[Exception]]] = Counter()


def report_failure(where: str, error: Exception) -> None:
    """Log what the receiver at `where` raised: the first of a type, and then each power of ten.

    A signal may have come while the receiver ran, and the program's handler raises in the midst of it. That
    error is meant for the program: it is raised again, and comes out of spin.
    """
    if is_from_signal_handler(error):
        raise error
    kind = where, type(error)
    with _lock:
        if kind not in _failures and len(_failures) >= _PLACES_LIMIT:
            return
        _failures[kind] += 1
        count = _failures[kind]
    if not is_told(count):
        return
    from goalwire.logging import get_logger  # needed only when something is broken
    from goalwire.tracebacks import traceback_text

    times = '' if count == 1 else f' ({count} times by now)'
    get_logger(LOGGER).error(
        f'{where}: its receiver raised; this delivery is lost{times}\n{traceback_text(error)}'
    )


def is_from_signal_handler(error: BaseException) -> bool:
    """Return whether a signal's handler raised the error, or a function that the handler called."""
    if current_thread() is not main_thread():
        return False  # Python calls handlers on the main thread only
    codes = {_code_of(signal.getsignal(number)) for number in signal.valid_signals()}
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code in codes:
            return True
        trace = trace.tb_next
    return False


def _code_of(handler: object) -> CodeType | None:
    """Return the code that a call of the handler runs; None if it is not written in Python."""
    for called in (handler, getattr(handler, '__call__', None)):  # noqa: B004 - the method, not whether it is there
        code = getattr(getattr(called, '__func__', called), '__code__', None)
        if isinstance(code, CodeType):
            return code
    return None
