"""Launch files as people write them, run by the real command; their processes tell how they were started."""

from __future__ import annotations

import json
import os
import queue
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from shutil import copytree
from types import TracebackType
from typing import Any, Self, TypeAlias

import pytest
from helpers.command_line import CommandLine, executable
from helpers.forking import ForkServer
from helpers.isolation import NETWORK, isolated_env
from helpers.patience import PATIENCE
from helpers.processes import Program

from goalwire.launching.source_programs import interpreter_lines

ROBOT = Path(__file__).parent / 'robot'
PROGRAMS = [
    *['arm', 'base', 'camera', 'controller', 'driver', 'faulty', 'lidar', 'never', 'plain', 'planner'],
    *['short', 'spawner', 'state_publisher', 'stubborn', 'teleop'],
]

_WARNINGS = {'PYTHONWARNINGS': 'error::ResourceWarning'}
_OF_LAUNCHES = ('goalwire.apps.cli.main', 'goalwire.launching.commands', 'launch_ros.actions')

Launch: TypeAlias = Callable[..., 'Launched']


@dataclass
class Process:
    """One process of a launch, with the facts that it told about itself."""

    program: str
    argv: list[str]
    params: dict[str, dict[str, Any]]
    remaps: list[str]
    env: dict[str, str]
    tty: bool
    cwd: str
    pid: int
    parent: int
    node: str | None = None
    ns: str | None = None

    @property
    def as_started(self) -> dict[str, Any]:
        """The facts that the launch file has a say in, without the empty ones."""
        told = {
            'program': self.program,
            'name': f'{self.ns or ""}/{self.node}' if self.node else self.ns,
            'argv': self.argv,
            'params': self.params,
            'remaps': self.remaps,
            'env': {name: value for name, value in self.env.items() if name != 'DEMO_PIPE'},
        }
        return {name: value for name, value in told.items() if value}

    @property
    def runs(self) -> bool:
        """Whether it runs still; a zombie does not."""
        try:
            return Path(f'/proc/{self.pid}/stat').read_text().rpartition(')')[2].split()[0] not in 'ZX'
        except OSError:
            return False


@dataclass
class Launched:
    """A running `ros2 launch`. Whatever it has started is killed when the block ends."""

    program: Program
    told: queue.Queue[str]
    processes: list[Process] = field(default_factory=list)

    def started(self, count: int) -> list[Process]:
        """Wait until so many more processes have told of themselves; all, in the order of their names."""
        for _ in range(count):
            try:
                told = self.told.get(timeout=PATIENCE)
            except queue.Empty:
                raise AssertionError(
                    f'{len(self.processes)} processes started:\n{self.program.output}'
                ) from None
            self.processes.append(Process(**json.loads(told)))
        return sorted(self.processes, key=lambda process: (process.program, process.ns or '', process.argv))

    def tree(self, count: int) -> list[dict[str, Any]]:
        """Return what so many processes were started with; each is a child of the launch."""
        found = self.started(count)
        assert {process.parent for process in found} == {self.program.pid}
        return [process.as_started for process in found]

    def end(self, *, code: int = 130) -> str:
        """Press Ctrl-C, wait for the end, make sure that nothing is left; the output."""
        self.program.send_signal(signal.SIGINT)
        return self.ended(code=code)

    def ended(self, *, code: int = 0) -> str:
        """Wait for the end, make sure that nothing is left; the output."""
        assert self.program.wait() == code, self.program.output
        assert [process.program for process in self.processes if process.runs] == []
        assert self.told.empty(), 'more processes than were expected'
        assert 'Traceback' not in self.program.output, self.program.output
        return self.program.output

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.program.close()
        while not self.told.empty():
            self.processes.append(Process(**json.loads(self.told.get())))
        pids = {process.pid for process in self.processes}
        pids |= {int(pid) for pid in re.findall(r'process started with pid \[(\d+)\]', self.program.output)}
        for pid in pids:
            with suppress(ProcessLookupError):
                os.killpg(pid, signal.SIGKILL)


@pytest.fixture(scope='session')
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package demo_robot, installed as colcon would install it."""
    prefix = tmp_path_factory.mktemp('install')
    share = prefix / 'share' / 'demo_robot'
    share.mkdir(parents=True)
    for folder in ('launch', 'config'):
        copytree(ROBOT / folder, share / folder)
    (share / 'package.xml').write_text(
        '<package format="3"><name>demo_robot</name><version>1.2.3</version><description>For tests'
        '</description><maintainer email="a@b.c">A</maintainer><license>Apache-2.0</license></package>'
    )
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / 'demo_robot').touch()
    programs = prefix / 'lib' / 'demo_robot'
    programs.mkdir(parents=True)
    for name in (*PROGRAMS, 'managed'):
        source = ROBOT / 'lib' / ('managed.py' if name == 'managed' else 'probe.py')
        program = programs / name
        text = source.read_text(encoding='utf-8')
        program.write_text(f'{interpreter_lines(sys.executable)}\n{text}', encoding='utf-8')
        program.chmod(0o755)
    return prefix


@pytest.fixture
def world(prefix: Path, tmp_path: Path) -> dict[str, str]:
    """An environment that knows demo_robot; log files and the processes' pipe are in the test's folder."""
    pipe = tmp_path / 'pipe'
    os.mkfifo(pipe)
    return {
        **isolated_env(NETWORK),
        'AMENT_PREFIX_PATH': str(prefix),
        'ROS_LOG_DIR': str(tmp_path / 'log'),
        'PROBE_PIPE': str(pipe),
        **_WARNINGS,
    }


@pytest.fixture(scope='session')
def launches() -> Iterator[ForkServer]:
    """The process that forks `ros2 launch` for all tests: it has imported what that imports.

    Tests share no more than the modules. Each command is a process of its own, in its test's environment.
    The filter of warnings is read when an interpreter starts, and so the server has it.
    """
    environment = {**isolated_env(NETWORK), **_WARNINGS}
    with ForkServer(_OF_LAUNCHES, environment) as server:
        yield server


@pytest.fixture
def ros2(world: dict[str, str], launches: ForkServer) -> CommandLine:
    """`ros2` in that environment."""
    return CommandLine(world, server=launches)


@pytest.fixture
def launch(world: dict[str, str], launches: ForkServer) -> Iterator[Launch]:
    """A function that launches a file, of demo_robot or by its path."""
    told: queue.Queue[str] = queue.Queue()
    pipe = os.open(world['PROBE_PIPE'], os.O_RDWR)  # with a writer of its own, so that no end of file comes

    def read() -> None:
        with os.fdopen(pipe, 'rb', buffering=0) as stream:
            rest = b''
            while True:
                *lines, rest = (rest + stream.read(65536)).split(b'\n')
                for line in lines:
                    if line == b'end':
                        return
                    told.put(line.decode())

    reader = threading.Thread(target=read, name='probe-reader')
    reader.start()
    with ExitStack() as stack:

        def start(file: str | Path, *arguments: str, **variables: str) -> Launched:
            words = [str(file)] if isinstance(file, Path) else ['demo_robot', file]
            environment = {**world, **variables}
            program = Program(executable(), 'launch', *words, *arguments, env=environment, server=launches)
            return stack.enter_context(Launched(program, told))

        try:
            yield start
        finally:
            stack.close()
            os.write(pipe, b'end\n')
            reader.join()
