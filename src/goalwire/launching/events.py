"""The events of a launch."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable
from typing import Any

from goalwire.launching.model import Action, Event, LaunchDescription


class IncludeLaunchDescription(Event):
    """Asks the launch to carry out a description; LaunchService.include_launch_description() emits it."""

    name = 'launch.events.IncludeLaunchDescription'

    def __init__(self, launch_description: LaunchDescription) -> None:
        self.launch_description = launch_description


class Shutdown(Event):
    """Asks the whole launch to end."""

    name = 'launch.events.Shutdown'

    def __init__(self, *, reason: str = 'reason not given', due_to_sigint: bool = False) -> None:
        self.reason = reason
        self.due_to_sigint = due_to_sigint


class TimerEvent(Event):
    """The period of a TimerAction has passed."""

    name = 'launch.events.TimerEvent'

    def __init__(self, *, timer_action: Action) -> None:
        self.timer_action = timer_action


class RunningProcessEvent(Event):
    """The base of events about a process that was started."""

    name = 'launch.events.process.RunningProcessEvent'

    def __init__(
        self,
        *,
        action: Action,
        name: str,
        cmd: list[str],
        cwd: str | None,
        env: dict[str, str] | None,
        pid: int,
    ) -> None:
        self.action = action
        self.process_name = name
        self.cmd = cmd
        self.cwd = cwd
        self.env = env
        self.pid = pid

    @property
    def execute_process_action(self) -> Action:
        return self.action


class ProcessStarted(RunningProcessEvent):
    """A process has been started."""

    name = 'launch.events.process.ProcessStarted'


class ProcessExited(RunningProcessEvent):
    """A process has ended; `returncode` is negative if a signal ended it."""

    name = 'launch.events.process.ProcessExited'

    def __init__(self, *, returncode: int, **details: Any) -> None:
        super().__init__(**details)
        self.returncode = returncode


class ProcessIO(RunningProcessEvent):
    """A process has printed; `text` is a piece of its output, as it arrived."""

    name = 'launch.events.process.ProcessIO'

    def __init__(self, *, text: bytes, fd: int, **details: Any) -> None:
        super().__init__(**details)
        self.text = text
        self.fd = fd

    @property
    def from_stdin(self) -> bool:
        return self.fd == 0

    @property
    def from_stdout(self) -> bool:
        return self.fd == 1

    @property
    def from_stderr(self) -> bool:
        return self.fd == 2


class ProcessStdin(ProcessIO):
    """Data for a process's standard input."""

    name = 'launch.events.process.ProcessStdin'

    def __init__(self, *, text: bytes, **details: Any) -> None:
        super().__init__(text=text, fd=0, **details)


class ProcessStdout(ProcessIO):
    """A process has printed to its standard output."""

    name = 'launch.events.process.ProcessStdout'

    def __init__(self, *, text: bytes, **details: Any) -> None:
        super().__init__(text=text, fd=1, **details)


class ProcessStderr(ProcessIO):
    """A process has printed to its standard error."""

    name = 'launch.events.process.ProcessStderr'

    def __init__(self, *, text: bytes, **details: Any) -> None:
        super().__init__(text=text, fd=2, **details)


class ProcessTargetedEvent(Event):
    """The base of events that concern the processes that a function matches."""

    name = 'launch.events.process.ProcessTargetedEvent'

    def __init__(self, *, process_matcher: Callable[[Any], bool]) -> None:
        self.process_matcher = process_matcher


class ShutdownProcess(ProcessTargetedEvent):
    """Asks the launch to end the matching processes: by SIGINT, then SIGTERM, then SIGKILL."""

    name = 'launch.events.process.ShutdownProcess'


class SignalProcess(ProcessTargetedEvent):
    """Asks the launch to send a signal, given by number or name, to the matching processes."""

    name = 'launch.events.process.SignalProcess'

    def __init__(
        self, *, signal_number: str | int | signal.Signals, process_matcher: Callable[[Any], bool]
    ) -> None:
        super().__init__(process_matcher=process_matcher)
        try:
            self.signal = (
                signal.Signals[signal_number]
                if isinstance(signal_number, str)
                else signal.Signals(signal_number)
            )
        except (KeyError, ValueError):
            raise ValueError(f'there is no signal {signal_number!r} on this system') from None

    @property
    def signal_name(self) -> str:
        return self.signal.name


def matches_action(target_action: Action) -> Callable[[Any], bool]:
    """Return a function that matches only the process of the given action."""
    return lambda action: action is target_action


def matches_pid(pid: int) -> Callable[[Any], bool]:
    """Return a function that matches the process with this pid."""
    return lambda action: (action.process_details or {}).get('pid') == pid


def matches_name(name: str) -> Callable[[Any], bool]:
    """Return a function that matches processes by name; the number that launch appends may be left out."""

    def matches(action: Any) -> bool:
        found = (action.process_details or {}).get('name', '')
        return found == name or re.sub(r'-\d+$', '', found) == name

    return matches


def matches_executable(name: str) -> Callable[[Any], bool]:
    """Return a function that matches processes whose program ends with this path."""
    return lambda action: ((action.process_details or {}).get('cmd') or [''])[0].split('/')[-1] == name


def is_shutdown(event: Event) -> bool:
    return isinstance(event, Shutdown)
