"""The DiagnosticStatus that diagnostic tasks fill."""

from __future__ import annotations

from typing import overload

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

__all__ = ['DiagnosticStatusWrapper']


class DiagnosticStatusWrapper(DiagnosticStatus):
    """A DiagnosticStatus with methods for its summary (level and message) and for its values."""

    @overload
    def summary(self, status: DiagnosticStatus, /) -> None: ...

    @overload
    def summary(self, level: bytes, message: object, /) -> None: ...

    def summary(self, *args: object) -> None:
        """Set the summary: `summary(level, message)`, or `summary(status)` to copy that of a status."""
        self.level, self.message = _read_summary(args)

    def clearSummary(self) -> None:
        """Set the level to OK, and empty the message."""
        self.summary(DiagnosticStatus.OK, '')

    @overload
    def mergeSummary(self, status: DiagnosticStatus, /) -> None: ...

    @overload
    def mergeSummary(self, level: bytes, message: object, /) -> None: ...

    def mergeSummary(self, *args: object) -> None:
        """Merge a second summary, given as for `summary`, into this one.

        The result has the higher level. If both levels are OK, or neither is, the messages are joined by a
        semicolon. If only one level is OK, the message of this level is dropped.
        """
        level, message = _read_summary(args)
        if (level > DiagnosticStatus.OK) == (self.level > DiagnosticStatus.OK):
            self.message = f'{self.message}; {message}' if self.message else message
        elif level > self.level:
            self.message = message
        self.level = max(self.level, level)

    def add(self, key: str, val: object) -> None:
        """Append a key with a value; a value that is not a str is converted by `str()`."""
        self.values.append(KeyValue(key=key, value=str(val)))


def _read_summary(args: tuple[object, ...]) -> tuple[bytes, str]:
    """Read level and message from the arguments of `summary`; raises TypeError for any other arguments."""
    match args:
        case (DiagnosticStatus() as status,):
            return status.level, status.message
        case (bytes() as level, message):
            return level, str(message)
        case _:
            raise TypeError(
                'a summary is given as a DiagnosticStatus, or as a level, such as DiagnosticStatus.WARN, '
                f'and a message; not as {args!r}'
            )
