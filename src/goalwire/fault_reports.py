"""Counts and logs faults on a wire: the first of each kind at each place, then each power of ten.

A message that breaks the rules is rejected and counted. If a receiver raises, the error is logged; the sender
and the transport's thread go on.
"""

from __future__ import annotations

import signal
from collections import Counter
from threading import Lock, current_thread, main_thread
from types import CodeType
from typing import Protocol

from goalwire.errors import peer_text

LOGGER = 'goalwire.transport'
"""The name of the logger for faults that belong to no node."""


class Origin(Protocol):
    """The place at which a rejected message arrived, such as an EndpointState."""

    @property
    def title(self) -> str:
        """The place as logs show it: "service '/add'"."""

    @property
    def logger(self) -> str:
        """The name of the logger for the place: the node's, so that lines also go to /rosout."""


class RejectCounters:
    """Counts rejected messages by kind of fault and by endpoint. Thread-safe."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._counts: Counter[tuple[str, str]] = Counter()

    def add(self, kind: str, reason: object, origin: Origin | None = None) -> None:
        """Count a rejection, and log it if `is_told` says so. Without `origin` it concerns the
        whole session.
        """
        title = '' if origin is None else origin.title
        count = self.count(kind, title)
        named = f'{"an" if kind[:1] in "aeiou" else "a"} {kind} was ignored'
        what = f'{title}: {named}' if title else named
        log_rejected(LOGGER if origin is None else origin.logger, what, count, reason)

    def count(self, kind: str, title: str) -> int:
        """Count one more fault of a kind at an endpoint, and return their number so far."""
        with self._lock:
            self._counts[kind, title] += 1
            return self._counts[kind, title]

    def counts(self) -> dict[str, int]:
        """Return the number of faults of each kind, summed over all endpoints."""
        totals: Counter[str] = Counter()
        with self._lock:
            for (kind, _), count in self._counts.items():
                totals[kind] += count
        return dict(totals)


def is_told(count: int) -> bool:
    """Return whether the `count`th fault of a kind is logged: the first one, and each power of ten is."""
    return str(count).strip('0') == '1'


def log_rejected(logger: str, what: str, count: int, reason: object, *, is_error: bool = False) -> None:
    """Log the `count`th rejection of one kind at one place, if `is_told` says so."""
    if not is_told(count):
        return
    from goalwire.logging import LoggingSeverity, get_logger  # imported here: needed only after faults

    told = peer_text(reason)
    if count == 1:
        text = f'{what} ({told}); further ones are counted, and told of at 10, 100, 1000, …'
    else:
        text = f'{what}, {count} times by now; the last time: {told}'
    get_logger(logger).log(text, LoggingSeverity.ERROR if is_error else LoggingSeverity.WARN)


_PLACES_LIMIT = 1000
"""The largest number of places and kinds of failures that are counted; further ones are not logged."""

_lock = Lock()
_failures: Counter[tuple[str, type[Exception]]] = Counter()


def report_failure(where: str, error: Exception) -> None:
    """Log an error that the receiver at `where` raised: the first one of each type, then each power of ten.

    If a signal comes while the receiver runs, the program's signal handler may raise inside the receiver.
    Such an error is meant for the program: it is raised again, and spin raises it.
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
    from goalwire.logging import get_logger  # imported here: needed only after faults
    from goalwire.tracebacks import traceback_text

    times = '' if count == 1 else f' ({count} times by now)'
    get_logger(LOGGER).error(
        f'{where}: its receiver raised; this delivery is lost{times}\n{traceback_text(error)}'
    )


def is_from_signal_handler(error: BaseException) -> bool:
    """Return whether a signal handler, or a function that it called, raised the error."""
    if current_thread() is not main_thread():
        return False  # Python calls signal handlers only on the main thread
    codes = {_code_of(signal.getsignal(number)) for number in signal.valid_signals()}
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code in codes:
            return True
        trace = trace.tb_next
    return False


def _code_of(handler: object) -> CodeType | None:
    """Return the code object that a call of the handler runs; None if the handler is not written
    in Python.
    """
    for called in (handler, getattr(handler, '__call__', None)):  # noqa: B004 - the method, not whether it is there
        code = getattr(getattr(called, '__func__', called), '__code__', None)
        if isinstance(code, CodeType):
            return code
    return None
