"""One log message on its way to the console and the sinks."""

from __future__ import annotations

from typing import NamedTuple

from goalwire.logging.severity import LoggingSeverity


class LogRecord(NamedTuple):
    """What was said, when (ns since the UNIX epoch), by which logger and from which source line."""

    stamp_ns: int
    severity: LoggingSeverity
    name: str
    message: str
    function: str
    file: str
    line: int
    origin: str = ''
    """The logger that this one descends from by get_child: the node's, which has a way to /rosout."""
