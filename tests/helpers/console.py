"""A robot, consoles beside it, and a browser in front of those."""

from __future__ import annotations

import atexit
import json
import os
import subprocess
from collections.abc import Mapping
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import Any

from helpers.forking import ForkServer
from helpers.isolation import isolated_env
from helpers.markdown import ROOT
from helpers.patience import BROWSER
from helpers.processes import Program

DATA = ROOT / 'tests' / 'data'
PROGRAMS = ROOT / 'tests' / 'apps' / 'console' / 'programs'
CONSOLE = """
import sys
from goalwire.apps.cli.main import run_command
sys.exit(run_command('goalwire', sys.argv[1:]))
"""


@cache
def _server() -> ForkServer:
    """The process that forks consoles and robots, for all tests of this process."""
    env = isolated_env('rmw_zenoh_cpp') | {'GOALWIRE_INTERFACE_PATH': str(DATA)}
    server = ForkServer(['console_imports'], env)
    atexit.register(server.close)
    return server


HURRY = """
from pkgutil import resolve_name
for name, seconds in waits.items():
    place, _, wait = name.rpartition('.')
    setattr(resolve_name(f'goalwire.apps.console.{place}'), wait, seconds)
"""
"""Has the console wait as long as `waits` says."""


WAITS = {'page.robot_view.RobotView.period': 0.25}
"""Four pictures of a moving robot a second are enough for a test: each costs browser and console much."""


class Stage:
    """A world with a robot and consoles, each a process."""

    def __init__(self, wire: str) -> None:
        self.env = isolated_env(wire) | {'GOALWIRE_INTERFACE_PATH': str(DATA)}
        self._programs = ExitStack()

    def robot(self) -> Program:
        """Start the robot."""
        robot = self.program(PROGRAMS / 'robot.py', str(DATA / 'robot.urdf'))
        robot.expect('ready')
        return robot

    def program(self, source: str | Path, *arguments: str) -> Program:
        """Start a program."""
        return self._enter(Program(source, *arguments, env=self.env, server=_server()))

    def command(self, line: str) -> str:
        """Run a command line of ros2, taken apart by a shell as a user's is; return what it writes."""
        words = subprocess.run(
            ['sh', '-c', line.replace('ros2', r"printf '%s\0'", 1)],
            capture_output=True,
            text=True,
            check=True,
        )
        arguments = words.stdout.split('\0')[:-1]
        with Program(CONSOLE, *arguments, env=self.env, server=_server()) as ran:
            return ran.succeed(BROWSER)

    def console(
        self,
        *arguments: str,
        waits: Mapping[str, float] | None = None,
        first: str = '',
        anew: bool = False,
    ) -> tuple[Program, str]:
        """Start a console on a free port; return it and its address.

        `waits`: seconds in place of its own, as in {'server.HEAD_S': 0.5}. `first`: what its process runs
        first; `anew`: before it imports anything.
        """
        hurry = f'waits = {WAITS | dict(waits or {})}\n{HURRY}'
        words = ('console', '--no-open', '--json', '--port', '0', *arguments)
        if anew:
            console = self._enter(Program(first + CONSOLE, *words, env=self.env))
        else:
            console = self.program(hurry + first + CONSOLE, *words)
        url = json.loads(console.expect(r'^\{.*\}$', BROWSER)[0])['url']
        return console, url

    def _enter(self, program: Program) -> Program:
        return self._programs.enter_context(program)

    def close(self) -> None:
        """End everything."""
        self._programs.close()


def screenshots() -> Path | None:
    """The folder in which screenshots are kept, where GOALWIRE_SCREENSHOTS names one."""
    named = os.environ.get('GOALWIRE_SCREENSHOTS')
    if not named:
        return None
    folder = Path(named)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def picture(page: Any, name: str) -> None:
    """Keep a screenshot if there is a folder for screenshots."""
    folder = screenshots()
    if folder:
        page.screenshot(path=str(folder / f'{name}.png'))
