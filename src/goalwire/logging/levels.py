"""The levels of loggers: dots make a hierarchy, an unset level is inherited, the root starts at INFO."""

from __future__ import annotations

from goalwire.locks import ForkableLock
from goalwire.logging.record import LoggingSeverity

_DEFAULT = LoggingSeverity.INFO
_CACHE_LIMIT = 1024
"""Names whose inherited level is remembered; programs that make a logger per goal must not grow for ever."""

_lock = ForkableLock()
_levels: dict[str, LoggingSeverity] = {}
_effective: dict[str, LoggingSeverity] = {}


def set_logger_level(name: str, level: int, detailed_error: bool = False) -> None:
    """Set a logger's level; '' is the root, UNSET returns to the inherited one.

    The root inherits from nobody: at UNSET it lets everything pass, as rcutils does. Raises ValueError for a
    number that is not a severity; `detailed_error` is rclpy's, without effect here.
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
    """Return the level set for exactly this logger, UNSET if there is none; the root always has one."""
    return _levels.get(name, LoggingSeverity.UNSET if name else _DEFAULT)


def get_logger_effective_level(name: str) -> LoggingSeverity:
    """Return the level in force: the logger's own, or that of its nearest ancestor that has one."""
    cache = _effective
    level = cache.get(name)
    if level is None:
        level = _inherit_level(name)
        with _lock:
            if len(cache) >= _CACHE_LIMIT:
                _forget_inherited()
            # If a level changed meanwhile, this is the old cache, which is no longer read.
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
