"""launch_testing.util: finds recorded processes, and makes a process that keeps a launch alive."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from typing import Any, Protocol, TypeAlias

from launch.actions import ExecuteLocal, ExecuteProcess
from launch.substitutions import TextSubstitution

__all__ = ['NO_CMD_ARGS', 'KeepAliveProc', 'NoMatchingProcessException', 'resolveProcesses']

NO_CMD_ARGS = object()
"""As `cmd_args`: matches only processes without arguments."""
ProcessChoice: TypeAlias = ExecuteLocal | str | None


class NoMatchingProcessException(Exception):
    """An error if no recorded process matches."""


class HasProcesses(Protocol):
    """A handler that has recorded processes."""

    def processes(self) -> Iterable[ExecuteLocal]:
        """Return the actions of all recorded processes."""


def resolveProcesses(
    info_obj: HasProcesses,
    *,
    process: ProcessChoice = None,
    cmd_args: Any = None,
    strict_proc_matching: bool = True,
) -> list[ExecuteLocal]:
    """Return recorded processes: all, the process of an action, or those whose name contains a text.

    Raises NoMatchingProcessException if none matches. With `strict_proc_matching` raises Exception if several
    names contain the text.
    """
    recorded = list(info_obj.processes())
    if process is None:
        if not recorded:
            raise NoMatchingProcessException('No data recorded for any process')
        return recorded
    if isinstance(process, ExecuteLocal):
        if process not in recorded:
            raise NoMatchingProcessException(f'No data recorded for proc {_describe(process)}')
        return [process]
    if not isinstance(process, str):
        raise TypeError(f"proc argument must be 'ExecuteProcess' or 'str' not {type(process)}")
    arguments = [cmd_args] if isinstance(cmd_args, str) else cmd_args
    found = [each for each in recorded if process in _name(each) and _has_arguments(each, arguments)]
    names = ', '.join(sorted(map(_describe, recorded)))
    if not found:
        raise NoMatchingProcessException(
            f"Did not find any processes matching name '{process}' and args '{arguments}'. Procs: {names}"
        )
    if strict_proc_matching and len(found) > 1:
        raise Exception(  # noqa: TRY002 - what launch_testing raises
            f"Found multiple processes matching name '{process}' and cmd_args '{arguments}'. Procs: {names}"
        )
    return found


def _details(process: ExecuteLocal) -> dict[str, Any]:
    return dict(process.process_details or {})


def _name(process: ExecuteLocal) -> str:
    return str(_details(process).get('name', ''))


def _command(process: ExecuteLocal) -> Sequence[str]:
    return [str(word) for word in _details(process).get('cmd', ())]


def _has_arguments(process: ExecuteLocal, arguments: Any) -> bool:
    if arguments is None:
        return True
    if arguments is NO_CMD_ARGS:
        return len(_command(process)) == 1
    return all(argument in _command(process)[1:] for argument in arguments)


def _describe(process: ExecuteLocal) -> str:
    if not process.process_details:
        described = process if hasattr(process, 'cmd') else getattr(process, 'process_description', None)
        words: list[list[Any]] = [list(word) for word in getattr(described, 'cmd', ())]
        if words and all(isinstance(part, TextSubstitution) for word in words for part in word):
            return ' '.join(''.join(part.text for part in word) for word in words)
        return 'Unknown - Process not launched yet'
    return ' '.join([_name(process), *_command(process)[1:]])


def KeepAliveProc() -> ExecuteProcess:
    """Return an action that runs a process which sleeps until it is stopped, so that the launch continues."""
    script = 'import threading\ntry:\n    threading.Event().wait()\nexcept KeyboardInterrupt:\n    pass'
    return ExecuteProcess(cmd=[sys.executable, '-c', script])
