"""A robot, consoles beside it, and a browser in front of those."""

from __future__ import annotations

import json
import os
import shutil
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from helpers.isolation import isolated_env
from helpers.markdown import ROOT
from helpers.processes import Program

CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')
PATIENCE_MS = 90_000
"""How long the page may take for what must happen: only a failure takes it."""
DATA = ROOT / 'tests' / 'data'
PROGRAMS = ROOT / 'tests' / 'console' / 'programs'
CONSOLE = """
import sys
from goalwire.cli.main import run_command
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

    def console(self, *arguments: str) -> tuple[Program, str]:
        """Start a console on a free port; return it and its address."""
        console = self.program(CONSOLE, 'console', '--no-open', '--json', '--port', '0', *arguments)
        url = json.loads(console.expect(r'^\{.*\}$')[0])['url']
        return console, url

    def close(self) -> None:
        """End everything."""
        self._programs.close()


def picture(page: Any, name: str) -> None:
    """Keep a screenshot, where GOALWIRE_SCREENSHOTS names a folder."""
    folder = os.environ.get('GOALWIRE_SCREENSHOTS')
    if folder:
        Path(folder).mkdir(parents=True, exist_ok=True)
        page.screenshot(path=str(Path(folder) / f'{name}.png'))
