"""Finds the exception in a program's output, and the line of the program that raised it."""

from __future__ import annotations

import re
from pathlib import Path

from goalwire.records import record

_HEAD = 'Traceback (most recent call last):'
_FRAME = re.compile(
    r'^\s+File "(?P<file>[^"]+)", line (?P<line>\d+), in \S+\n\s+(?P<source>.+)', re.MULTILINE
)


@record
class Failure:
    """An exception in a student's program."""

    text: str
    """The exception's type without the module, and the exception's message: `ValueError: too hot`."""
    advice: str
    """The program's line that raised the exception, if the traceback shows it, and the message's rest."""


def find_failure(output: str, program: str) -> Failure | None:
    """Return the last exception in the output of the file named `program`; None if it shows no traceback.

    The failure names the innermost line of that file in the traceback. If this line calls `spin`, the error
    comes from a callback outside of the file, so no line is named.
    """
    _, head, tail = output.rpartition(_HEAD)
    if not head:
        return None
    lines = tail.splitlines()[1:]
    at = next((index for index, line in enumerate(lines) if line and not line[0].isspace()), None)
    if at is None:
        return None
    qualified, colon, message = lines[at].partition(':')
    frames = [
        frame for frame in _FRAME.finditer('\n'.join(lines[:at])) if Path(frame['file']).name == program
    ]
    last = frames[-1:] if frames and 'spin(' not in frames[-1]['source'] else []
    advice = [f'{program}, line {frame["line"]}: {frame["source"]}' for frame in last]
    if 'the first argument of ActionServer is the node' in message:
        advice.append('the node comes first: ActionServer(self, …)')
    for line in lines[at + 1 :]:
        if not line[:1].isspace():
            break
        advice.append(line.strip())
    return Failure(qualified.rpartition('.')[2] + colon + message, '\n       '.join(advice))
