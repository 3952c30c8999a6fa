"""Tasks that report the state of a part, and the updater that runs them and publishes their statuses."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias, overload, runtime_checkable

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.timer import Timer

from diagnostic_updater._diagnostic_status_wrapper import DiagnosticStatusWrapper

__all__ = [
    'CompositeDiagnosticTask',
    'DiagnosticTask',
    'DiagnosticTaskVector',
    'FunctionDiagnosticTask',
    'Updater',
]

TaskFunction: TypeAlias = Callable[[DiagnosticStatusWrapper], DiagnosticStatusWrapper]

PERIOD = 'diagnostic_updater.period'
USE_FQN = 'diagnostic_updater.use_fqn'


class DiagnosticTask:
    """A named task that fills a status; derive from it and override `run`."""

    def __init__(self, name: str) -> None:
        self.name = name

    def getName(self) -> str:
        """Return the task's name."""
        return self.name

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fill the status, and return it."""
        return stat


class FunctionDiagnosticTask(DiagnosticTask):
    """A task made of a function, which takes a status and returns it filled."""

    def __init__(self, name: str, fn: TaskFunction) -> None:
        super().__init__(name)
        self.fn = fn

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Let the function fill the status."""
        return self.fn(stat)


class CompositeDiagnosticTask(DiagnosticTask):
    """Several tasks that fill one status: values are appended, summaries are merged."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.tasks: list[DiagnosticTask] = []

    def addTask(self, t: DiagnosticTask) -> None:
        """Append a task."""
        self.tasks.append(t)

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Run the tasks in order; each task starts with the summary that the given status had."""
        passed_in, merged = DiagnosticStatusWrapper(), DiagnosticStatusWrapper()
        passed_in.summary(stat)
        for task in tuple(self.tasks):
            stat.summary(passed_in)
            stat = _run(task.name, task.run, stat)
            merged.mergeSummary(stat)
        stat.summary(merged)
        return stat


@runtime_checkable
class _Task(Protocol):
    """The methods of DiagnosticTask that `add` needs: any object with these methods is accepted."""

    def getName(self) -> str: ...

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper: ...


class _NamedRun(Protocol):
    """An entry of a DiagnosticTaskVector: a name, and a `run` that also sets the status's name."""

    @property
    def name(self) -> str: ...

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper: ...


class DiagnosticTaskVector:
    """A list of tasks. Threads may change the list while other threads run the tasks."""

    class DiagnosticTaskInternal:
        """An entry of a DiagnosticTaskVector: a task's name, and the function to call."""

        def __init__(self, name: str, fn: TaskFunction) -> None:
            self.name = name
            self.fn = fn

        def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
            """Set the status's name to the task's, and let the function fill the status."""
            stat.name = self.name
            return _run(self.name, self.fn, stat)

    def __init__(self) -> None:
        self.tasks: list[_NamedRun] = []
        self.lock = threading.Lock()  # guards the list of tasks; not held while a task runs

    def addedTaskCallback(self, task: _NamedRun) -> None:
        """Do nothing. Override this method to be called with each task that is added."""

    @overload
    def add(self, task: _Task, /) -> None: ...

    @overload
    def add(self, name: str, fn: TaskFunction, /) -> None: ...

    def add(self, *args: object) -> None:
        """Add a task: `add(task)`, or `add(name, function)`; TypeError for anything else."""
        match args:
            case (str() as name, fn) if callable(fn):
                task = self.DiagnosticTaskInternal(name, fn)
            case (_Task() as given,):
                task = self.DiagnosticTaskInternal(given.getName(), given.run)
            case _:
                raise TypeError(f'add takes a DiagnosticTask, or a name and a function; not {args!r}')
        with self.lock:
            self.tasks.append(task)
        self.addedTaskCallback(task)

    def removeByName(self, name: str) -> bool:
        """Remove the first task of that name; return whether there was such a task."""
        with self.lock:
            for index, task in enumerate(self.tasks):
                if task.name == name:
                    del self.tasks[index]
                    return True
        return False

    def _copy_tasks(self) -> tuple[_NamedRun, ...]:
        with self.lock:
            return tuple(self.tasks)


class Updater(DiagnosticTaskVector):
    """Runs its tasks every `period` seconds, and publishes their statuses on /diagnostics.

    The parameter `diagnostic_updater.period` replaces the period. If `diagnostic_updater.use_fqn` is true,
    the statuses carry the node's name with its namespace, else only its name.
    """

    def __init__(self, node: Node, period: float = 1.0) -> None:
        super().__init__()
        self.node = node
        self.publisher: Publisher[DiagnosticArray] = node.create_publisher(DiagnosticArray, '/diagnostics', 1)
        self.period_parameter = PERIOD
        self.use_fqn_parameter = USE_FQN
        self.verbose = False
        self.hwid = ''
        self.warn_nohwid_done = False
        use_fqn = _declare(node, USE_FQN, False)
        self.node_name = node.get_fully_qualified_name() if use_fqn else node.get_name()
        self._period: float = _declare(node, PERIOD, period)  # a period given as an int stays an int
        self.timer: Timer = node.create_timer(self._period, self.update)

    @property
    def period(self) -> float:
        """The seconds between two updates. A new value takes effect at once."""
        return self._period

    @period.setter
    def period(self, period: float) -> None:
        timer = self.node.create_timer(period, self.update)  # refuses a period below 0: the old timer stays
        self.node.destroy_timer(self.timer)
        self.timer, self._period = timer, period

    def setHardwareID(self, hwid: str) -> None:
        """Set the hardware's identity, which each status carries; 'none' if there is no hardware."""
        self.hwid = hwid

    def update(self) -> None:
        """Run all tasks and publish their statuses. The timer calls this; a program may call it, too."""
        statuses = []
        for task in self._copy_tasks():
            status = DiagnosticStatusWrapper(
                level=DiagnosticStatus.ERROR,
                name=task.name,
                message='No message was set',
                hardware_id=self.hwid,
            )
            status = task.run(status)
            statuses.append(status)
            if self.verbose and status.level != DiagnosticStatus.OK:
                self.node.get_logger().warning(
                    f'Non-zero diagnostic status. Name: {status.name}, status {ord(status.level)}: '
                    f'{status.message}'
                )
        if all(status.level == DiagnosticStatus.OK for status in statuses):
            self._warn_without_hardware_id()
        self.publish(statuses)

    def force_update(self) -> None:
        """Call `update` at once, without waiting for the timer."""
        self.update()

    def broadcast(self, lvl: bytes, msg: str) -> None:
        """Publish a status with this level and message for each task, without running the tasks."""
        statuses = []
        for task in self._copy_tasks():
            status = DiagnosticStatusWrapper(name=task.name)
            status.summary(lvl, msg)
            statuses.append(status)
        self.publish(statuses)

    def publish(self, msg: DiagnosticStatus | Sequence[DiagnosticStatus]) -> None:
        """Publish copies of statuses, with the node's name put before each status's name."""
        given = [msg] if isinstance(msg, DiagnosticStatus) else msg
        array = DiagnosticArray(
            status=[
                DiagnosticStatus(
                    level=status.level,
                    name=f'{self.node_name}: {status.name}',
                    message=status.message,
                    hardware_id=status.hardware_id,
                    values=status.values,
                )
                for status in given
            ]
        )
        array.header.stamp = self.node.get_clock().now().to_msg()
        self.publisher.publish(array)

    def addedTaskCallback(self, task: _NamedRun) -> None:
        """Publish the status 'Node starting up' for a new task."""
        status = DiagnosticStatusWrapper(name=task.name)
        status.summary(DiagnosticStatus.OK, 'Node starting up')
        self.publish(status)

    def _warn_without_hardware_id(self) -> None:
        """Warn once if no hardware ID was set.

        `update` calls this only if all statuses are OK, since the ID may be set late.
        """
        if not self.hwid and not self.warn_nohwid_done:
            self.warn_nohwid_done = True
            self.node.get_logger().warning(
                'diagnostic_updater: No HW_ID was set. Call setHardwareID with the identity of the device, '
                "or with 'none' if there is no device."
            )


def _run(name: str, fn: TaskFunction, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
    """Call a task's function.

    Raises TypeError if the function returns no status, e.g. has no return statement.
    """
    filled = fn(stat)
    if not isinstance(filled, DiagnosticStatus):
        raise TypeError(
            f'diagnostic task {name!r} returned {filled!r}, not a status: let it return the one it was given'
        )
    return filled


def _declare(node: Node, name: str, default: float | bool) -> Any:
    """Declare a parameter if it is not declared yet, and return its value."""
    if not node.has_parameter(name):
        node.declare_parameter(name, default)
    return node.get_parameter(name).value
