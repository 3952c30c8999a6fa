"""Keeps loggers' levels: dots in names make a hierarchy, an unset level is inherited, the root has INFO."""

from __future__ import annotations

from goalwire.locks import ForkableLock
from goalwire.logging.record import LoggingSeverity

_DEFAULT = LoggingSeverity.INFO
_CACHE_LIMIT = 1024
"""The largest number of names whose inherited level is cached: programs may make a name for each goal."""

_lock = ForkableLock()
_levels: dict[str, LoggingSeverity] = {}
_effective: dict[str, LoggingSeverity] = {}


def set_logger_level(name: str, level: int, detailed_error: bool = False) -> None:
    """Set a logger's level; '' is the root logger. After UNSET the logger inherits its level again.

    The root inherits no level: with UNSET it lets every record pass, as in rcutils. Raises ValueError for a
    number that is not a severity; `detailed_error` is a parameter of rclpy's function, and has no effect
    here.
    """
    del detailed_error
    severity = LoggingSeverity(level)
    with _lock:
        if name and severity is LoggingSeverity.UNSET:
            _levels.pop(name, None)
        else:
            _levels[name] = severity
        _forget_inherited()


def get_logger_level(name: str) -> LoggingSeverity:
    """Return the level that was set for exactly this logger, else UNSET; the root always has a level."""
    return _levels.get(name, LoggingSeverity.UNSET if name else _DEFAULT)


def get_logger_effective_level(name: str) -> LoggingSeverity:
    """Return the level that applies: the logger's own, or that of its nearest ancestor with a level."""
    cache = _effective
    level = cache.get(name)
    if level is None:
        level = _inherit_level(name)
        with _lock:
            if len(cache) >= _CACHE_LIMIT:
                _forget_inherited()
            # If a level was changed meanwhile, `cache` is the old dictionary, which no reader uses any more.
            cache[name] = level
    return level


def reset_levels() -> None:
    """Forget every level that was set."""
    with _lock:
        _levels.clear()
        _forget_inherited()


def _inherit_level(name: str) -> LoggingSeverity:
    levels = _levels
    while name:
        if name in levels:
            return levels.get(name, _DEFAULT)
        name = name.rpartition('.')[0]
    return levels.get('', _DEFAULT)


def _forget_inherited() -> None:
    global _effective  # noqa: PLW0603 - readers take the dictionary they find, without a lock
    _effective = {}
