"""Keeps the log lines of all nodes, from /rosout, and filters them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from itertools import islice
from typing import Any

from goalwire.logging import LoggingSeverity
from goalwire.observe.messages import cut
from goalwire.records import record

KEPT = 5000
LEVELS = {level.value: level.name for level in LoggingSeverity if level}
_MOST_TEXT = 4000
_MOST_NAME = 300


@record
class LogLine:
    """One line of a log; `stamp` is in s since 1970, by the clock of the node that logged the line."""

    number: int
    stamp: float
    level: int
    node: str
    text: str
    place: str
    """The file, the line of code and the function that logged the line."""

    @property
    def level_name(self) -> str:
        """The name of the level, from DEBUG to FATAL."""
        return LEVELS.get(self.level, str(self.level))


class LogBook:
    """The latest lines."""

    def __init__(self, kept: int = KEPT) -> None:
        self._lines: deque[LogLine] = deque(maxlen=kept)
        self._count = 0

    def take(self, message: Any, _at: float = 0.0) -> None:
        """Add a line from an rcl_interfaces/msg/Log."""
        self._count += 1
        file, function = message.file[:_MOST_NAME], message.function[:_MOST_NAME]
        place = f'{file}:{message.line} {function}' if file else ''
        self._lines.append(
            LogLine(
                self._count,
                message.stamp.sec + message.stamp.nanosec / 1e9,
                message.level,
                message.name[:_MOST_NAME],
                cut(message.msg, _MOST_TEXT),
                place,
            )
        )

    @property
    def version(self) -> int:
        """The number of lines so far, with those that are not kept any more."""
        return self._count

    @property
    def nodes(self) -> list[str]:
        """The names of the loggers of the kept lines, sorted."""
        return sorted({line.node for line in self._lines})

    def since(self, version: int, text: str) -> list[LogLine]:
        """Return the lines after line number `version` that contain `text`, the oldest first."""
        new = min(self._count - version, len(self._lines))
        lines = islice(self._lines, len(self._lines) - new, None)
        return [line for line in lines if text in line.node or text in line.text]

    def latest(self, most: int, *, least_level: int = 0, node: str = '', text: str = '') -> list[LogLine]:
        """Return at most `most` lines that the filters let pass, the newest first."""
        return list(islice(self._passing(least_level, node, text), most))

    def _passing(self, least_level: int, node: str, text: str) -> Iterator[LogLine]:
        wanted = text.lower()
        for line in reversed(self._lines):
            if line.level < least_level or (node and line.node != node):
                continue
            if wanted and wanted not in line.text.lower() and wanted not in line.node.lower():
                continue
            yield line
