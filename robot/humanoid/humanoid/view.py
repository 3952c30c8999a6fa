"""The robot's page in the browser: goalwire's console, if the console is installed.

`python -m humanoid.view` runs it; like the robot's programs, it ends with the process that started it.
"""

from __future__ import annotations

import os
import runpy
import sys
from collections.abc import Sequence
from importlib.util import find_spec

from humanoid import lifeline

NAME = 'view'
NEEDED = 'nicegui'
PORT = 8420
"""The page's port, if it is free. It is fixed, so that an open page reconnects when the robot restarts."""


class NoView(Exception):
    """The console is not installed; the text says what to do."""


def command() -> Sequence[str]:
    """Return the command line that serves the page and opens it in the browser. Raises NoView."""
    for package in ('goalwire', NEEDED):
        if find_spec(package) is None:
            raise NoView(f"--view needs the package {package}: pip install 'goalwire[console]'")
    return [sys.executable, '-m', 'humanoid.view']


def is_served(line: str) -> bool:
    """Return True if a line of the program's output says that the page is served."""
    return line.startswith('the console is at ')


def main() -> None:
    """Run `goalwire console` in this process."""
    lifeline.hold(os.environ)
    print(f'pid {os.getpid()}', flush=True)
    sys.argv = ['goalwire', 'console', '--prefer-port', str(PORT)]
    runpy.run_module('goalwire', run_name='__main__')


if __name__ == '__main__':
    main()
