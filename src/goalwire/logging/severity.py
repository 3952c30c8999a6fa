"""How grave a log message is, with the numbers of rcl_interfaces/msg/Log."""

from __future__ import annotations

from enum import IntEnum

from goalwire.errors import UnknownSeverityError


class LoggingSeverity(IntEnum):
    """A message's severity, or the least one that a logger lets pass; UNSET inherits."""

    UNSET = 0
    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50


def get_logging_severity_from_string(log_severity: str) -> LoggingSeverity:
    """Return the severity of a name in any case; raises UnknownSeverityError (a RuntimeError)."""
    try:
        return LoggingSeverity[log_severity.upper()]
    except KeyError:
        known = ', '.join(member.name.lower() for member in LoggingSeverity)
        raise UnknownSeverityError(
            f"Failed to get severity name: '{log_severity}' is not one of {known}"
        ) from None
