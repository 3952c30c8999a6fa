"""launch_testing.asserts: checks of the output and exit codes of processes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from launch_testing.matching import build_text_match, remove_ansi_escape_sequences
from launch_testing.util import NO_CMD_ARGS, ProcessChoice, resolveProcesses

__all__ = [
    'EXIT_OK',
    'EXIT_SIGINT',
    'EXIT_SIGKILL',
    'EXIT_SIGQUIT',
    'EXIT_SIGSEGV',
    'NO_CMD_ARGS',
    'SequentialTextChecker',
    'assertDefaultStream',
    'assertExitCodes',
    'assertInStderr',
    'assertInStdout',
    'assertInStream',
    'assertSequentialStdout',
]

EXIT_OK = 0
EXIT_FORCED = 1
EXIT_SIGINT = 130
EXIT_SIGQUIT = 131
EXIT_SIGKILL = 137
EXIT_SIGSEGV = 139
_ALLOWED = (EXIT_OK,) if os.name != 'nt' else (EXIT_OK, EXIT_FORCED)
_NEAR = 3
"""The number of lines that a failure shows on each side of the last match."""


def assertExitCodes(
    proc_info: Any,
    allowable_exit_codes: Sequence[int] = _ALLOWED,
    process: ProcessChoice = None,
    cmd_args: Any = None,
    *,
    strict_proc_matching: bool = True,
) -> None:
    """Raise AssertionError if a process ended with an exit code that is not allowed."""
    for code in allowable_exit_codes:
        if not isinstance(code, int):
            raise AssertionError(f'Provided exit code {code} is not an int')  # noqa: TRY004
    for each in resolveProcesses(
        proc_info, process=process, cmd_args=cmd_args, strict_proc_matching=strict_proc_matching
    ):
        info = proc_info[each]
        if info.returncode not in allowable_exit_codes:
            raise AssertionError(f'Proc {info.process_name} exited with code {info.returncode}')


def assertInStream(
    proc_output: Any,
    expected_output: Any,
    process: ProcessChoice,
    cmd_args: Any = None,
    *,
    output_filter: Callable[[str], str] | None = None,
    strict_proc_matching: bool = True,
    strip_ansi_escape_sequences: bool = True,
    stream: str = 'stderr',
) -> None:
    """Raise AssertionError if no process has printed the expected text or pattern, or several in order."""
    meant = resolveProcesses(
        proc_output, process=process, cmd_args=cmd_args, strict_proc_matching=strict_proc_matching
    )
    if output_filter is not None and not callable(output_filter):
        raise ValueError('output_filter is not callable')
    if stream not in {'stdout', 'stderr'}:
        raise ValueError("Invalid value for stream; must be 'stdout' or 'stderr'")
    match = build_text_match(expected_output)
    for each in meant:
        data = b''.join(io.text for io in proc_output[each] if getattr(io, f'from_{stream}'))
        text = data.decode(errors='replace')
        if strip_ansi_escape_sequences:
            text = remove_ansi_escape_sequences(text)
        if match(text if output_filter is None else output_filter(text)) is not None:
            return
    names = ', '.join(sorted((each.process_details or {})['name'] for each in meant))
    raise AssertionError(
        f"Did not find '{expected_output}' in output for any of the matching processes: {names}"
    )


def assertInStdout(*args: Any, **kwargs: Any) -> None:
    """Do what `assertInStream` does, but only for the standard output."""
    assertInStream(*args, **kwargs, stream='stdout')


def assertInStderr(*args: Any, **kwargs: Any) -> None:
    """Do what `assertInStream` does, but only for the standard error."""
    assertInStream(*args, **kwargs, stream='stderr')


def assertDefaultStream() -> str:
    """Return the name of the stream that assertions check by default."""
    return 'stderr'


class SequentialTextChecker:
    """Finds expected texts, in order, in a list of outputs; each output may have several lines."""

    def __init__(self, output: Sequence[str]) -> None:
        self._output = output
        self._index = 0
        self._offset = 0
        """The end of the last match: `_index` is its output, `_offset` its position there."""

    def assertInText(self, msg: str) -> None:
        """Raise AssertionError if the outputs do not contain the text after the last match."""
        offset = self._offset
        for index in range(self._index, len(self._output)):
            found = self._output[index].find(msg, offset)
            if found != -1:
                self._index, self._offset = index, found + len(msg)
                return
            offset = 0
        raise AssertionError(
            f"'{msg}' not found in sequence after previous match.  "
            f'The output near the last matched line:\n{self.get_nearby_lines()}'
        )

    assertInStdout = assertInText

    def get_nearby_lines(self) -> str:
        """Return the lines around the last match."""
        first = max(0, self._index - 2)
        text = ''.join(self._output[first : self._index + 4])
        position = len(''.join(self._output[first : self._index])) + self._offset
        ends = [index for index, character in enumerate(text) if character == '\n']
        before, after = [index for index in ends if index < position], [i for i in ends if i > position]
        start = before[-_NEAR] + 1 if len(before) >= _NEAR else 0
        return text[start : after[:_NEAR][-1] if after else position]


@contextmanager
def assertSequentialStdout(
    proc_output: Any, process: ProcessChoice, cmd_args: Any = None
) -> Iterator[SequentialTextChecker]:
    """Yield a checker that finds texts in order in one process's output."""
    [meant] = resolveProcesses(proc_output, process=process, cmd_args=cmd_args, strict_proc_matching=True)
    yield SequentialTextChecker([io.text.decode(errors='replace') for io in proc_output[meant]])
