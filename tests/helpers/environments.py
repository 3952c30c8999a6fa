"""Virtual environments for tests that install things."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from helpers.fresh import clean_environment

if sys.platform != 'win32':
    import fcntl

ROOT = Path(__file__).parents[2]
_TESTS_SITE = next(entry for entry in sys.path if entry.endswith('site-packages'))
_UNREACHABLE = ('connection', 'retrying', 'temporary failure', 'timed out', 'name resolution')


@contextmanager
def _alone(file: Path) -> Iterator[None]:
    """Hold a lock against pytest's other workers and against other runs (if there is flock)."""
    with file.open('w', encoding='utf-8') as lock:
        if sys.platform != 'win32':
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Return a folder of this test run that the first worker to ask for it fills; the others wait.

    What `make` raises comes through, and the next to ask begins anew.
    """
    run = factory.getbasetemp()
    run = run.parent if 'PYTEST_XDIST_WORKER' in os.environ else run
    folder, finished = run / name, run / f'{name}.finished'
    with _alone(run / f'{name}.lock'):
        if not finished.exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            make(folder)
            finished.touch()
    return folder


class CannotInstall(Exception):
    """pip gave up; the text is its own. `unreachable` is true if it could not even talk to a registry."""

    def __init__(self, stderr: str) -> None:
        super().__init__(''.join(stderr.strip().splitlines()[-1:]))
        self.unreachable = any(sign in stderr.lower() for sign in _UNREACHABLE)


@dataclass(frozen=True)
class Environment:
    """A virtual environment without pip; the tests' own pip installs into it."""

    folder: Path

    @property
    def python(self) -> Path:
        return self.folder / ('Scripts/python.exe' if os.name == 'nt' else 'bin/python')

    @property
    def site(self) -> Path:
        """Its site-packages."""
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

    def require(self, *arguments: str) -> None:
        """Install; raises CannotInstall."""
        done = self.install(*arguments)
        if done.returncode:
            raise CannotInstall(done.stderr)

    def borrow_tests_packages(self) -> None:
        """Let it import what the tests' own environment has, after its own packages; goalwire, too."""
        (self.site / 'those_of_the_tests.pth').write_text(f'import site; site.addsitedir({_TESTS_SITE!r})\n')

    def install_editable(self, *sources: Path | str) -> None:
        """Install packages with `pip install -e`, built by the tests' own setuptools and hatchling.

        It needs no package index, and borrows the tests' packages. Raises CannotInstall.
        """
        self.borrow_tests_packages()
        self.require('--no-build-isolation', '--no-index', *(f'--editable={source}' for source in sources))

    @classmethod
    def kept(cls, folder: Path, *requirements: str) -> Environment:
        """Return the environment of `folder`, made with the packages named where that was not done yet.

        Raises CannotInstall.
        """
        finished = folder / 'finished'
        with _alone(folder.with_name(f'{folder.name}.lock')):
            if finished.exists():
                return cls(folder)
            environment = cls.create(folder)
            environment.require('--retries=1', '--timeout=15', '--no-compile', *requirements)
            finished.touch()
            return environment

    @classmethod
    def create(cls, folder: Path) -> Environment:
        """Make an empty virtual environment of this Python."""
        venv.create(folder, symlinks=os.name != 'nt')
        return cls(folder)


def kept_for_all(cache: pytest.Cache | None, *requirements: str) -> Environment:
    """Return an environment with the packages named, which all tests and all test runs of this clone share.

    Raises CannotInstall.
    """
    assert cache is not None
    title = '-'.join([str(sys.implementation.cache_tag), *requirements]).replace('==', '-')
    return Environment.kept(cache.mkdir('environments') / title, *requirements)
