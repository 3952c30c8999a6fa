"""How a command ends: its exit code, and the one line that says why."""

from __future__ import annotations

from enum import IntEnum

from goalwire.errors import with_advice


class Outcome(IntEnum):
    """The exit codes of every command."""

    OK = 0
    FAILED = 1
    """All failures without a code of their own."""
    USAGE = 2
    """The command line is wrong: an unknown verb or flag, or a missing argument."""
    NOT_FOUND = 3
    """A named topic, service, action, node, parameter, type, package or file does not exist."""
    BAD_VALUE = 4
    """A value does not fit its type, or its text cannot be read."""
    TIMEOUT = 5
    """A message, answer or result did not come in time."""
    SERVER_LOST = 6
    """The server went away, or gave the request up."""
    REFUSED = 7
    """The peer refused a goal, a parameter, a transition, or a request beyond its limit."""
    ABORTED = 8
    """The goal was aborted."""
    CANCELED = 9
    """The goal was cancelled."""
    UNAVAILABLE = 10
    """The command needs something that is missing here: a wire, a terminal, or an extra."""
    INTERRUPTED = 130
    """Ended by Ctrl-C."""
    TERMINATED = 143
    """Ended by SIGTERM."""
    CLOSED_PIPE = 141
    """The output's reader has closed the pipe, as `| head` does. Of all failures only this prints no line."""


class CommandError(Exception):
    """Ends a command. `problem` says what is wrong, `advice` what to do next; both go on one line.

    `main` turns it into that line and the exit code; it is not part of the library's API.
    """

    def __init__(self, outcome: Outcome, problem: str, advice: str = '') -> None:
        super().__init__(with_advice(problem, advice))
        self.outcome = outcome
