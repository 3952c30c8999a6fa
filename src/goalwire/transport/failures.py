"""A receiver that raises takes nobody else down: neither the sender nor the transport's thread."""

from __future__ import annotations

from collections import Counter
from threading import Lock

from goalwire.transport.reject_counters import LOGGER, is_told

_PLACES_LIMIT = 1000
"""Places whose failures are told apart; beyond them nothing new is logged."""

_lock = Lock()
_failures: Counter[tuple[str, type[Exception]]] = Counter()


def report_failure(where: str, error: Exception) -> None:
    """Log what the receiver at `where` raised: the first of a type, and then each power of ten."""
    kind = where, type(error)
    with _lock:
        if kind not in _failures and len(_failures) >= _PLACES_LIMIT:
            return
        _failures[kind] += 1
        count = _failures[kind]
    if not is_told(count):
        return
    from goalwire.logging import get_logger  # needed only when something is broken
    from goalwire.logging.tracebacks import traceback_text

    times = '' if count == 1 else f' ({count} times by now)'
    get_logger(LOGGER).error(
        f'{where}: its receiver raised; this delivery is lost{times}\n{traceback_text(error)}'
    )


def forget() -> None:
    """Begin to count anew."""
    with _lock:
        _failures.clear()
