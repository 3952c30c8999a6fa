"""Virtual environments for tests that install things."""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from dataclasses import dataclass
from pathlib import Path

from helpers.fresh import clean_environment

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Environment:
    """A virtual environment without pip; the tests' own pip installs into it."""

    folder: Path

    @property
    def python(self) -> Path:
        return self.folder / ('Scripts/python.exe' if os.name == 'nt' else 'bin/python')

    @property
    def site(self) -> Path:
        """Its site-packages, once something is installed."""
        return next(self.folder.glob('[Ll]ib/**/site-packages'))

    def files(self) -> set[Path]:
        """All its files, caches of byte code aside."""
        return {file for file in self.folder.rglob('*') if file.is_file() and file.suffix != '.pyc'}

    def install(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run `pip install`; the caller looks at the outcome."""
        return self._pip('install', '--quiet', *arguments)

    def uninstall(self, distribution: str) -> subprocess.CompletedProcess[str]:
        """Run `pip uninstall`."""
        return self._pip('uninstall', '--yes', distribution)

    def _pip(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        pip = [sys.executable, '-m', 'pip', '--python', str(self.python), '--disable-pip-version-check']
        return subprocess.run(
            [*pip, *arguments],
            env=clean_environment(), capture_output=True, text=True, timeout=300, check=False,
        )  # fmt: skip

    @classmethod
    def create(cls, folder: Path) -> Environment:
        """Make an empty virtual environment of this Python."""
        venv.create(folder, symlinks=os.name != 'nt')
        return cls(folder)
