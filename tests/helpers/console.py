"""A robot, consoles beside it, and a browser in front of those."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from helpers.isolation import isolated_env
from helpers.markdown import ROOT
from helpers.patience import BROWSER
from helpers.processes import Program

CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')
DATA = ROOT / 'tests' / 'data'
PROGRAMS = ROOT / 'tests' / 'apps' / 'console' / 'programs'
CONSOLE = """
import sys
from goalwire.apps.cli.main import run_command
sys.exit(run_command('goalwire', sys.argv[1:]))
"""


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
        return self._programs.enter_context(Program(source, *arguments, env=self.env))

    def command(self, line: str) -> str:
        """Run a command line of ros2 in a shell, as a user would; return what it writes."""
        done = subprocess.run(
            ['sh', '-c', line.replace('ros2', f'{sys.executable} -m goalwire', 1)],
            env=self.env,
            capture_output=True,
            text=True,
            timeout=BROWSER,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def console(self, *arguments: str, head_s: float | None = None, first: str = '') -> tuple[Program, str]:
        """Start a console on a free port; return it and its address.

        `head_s`: how long heads may take. `first`: a program that its process runs before.
        """
        hurry = (
            ''
            if head_s is None
            else f'import goalwire.apps.console.server as server; server.HEAD_S = {head_s}'
        )
        console = self.program(
            first + hurry + CONSOLE, 'console', '--no-open', '--json', '--port', '0', *arguments
        )
        url = json.loads(console.expect(r'^\{.*\}$', BROWSER)[0])['url']
        return console, url

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
    """Keep a screenshot, where there is a folder for them."""
    folder = screenshots()
    if folder:
        page.screenshot(path=str(folder / f'{name}.png'))
