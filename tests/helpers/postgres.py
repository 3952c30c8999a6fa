"""A Postgres of one's own: Debian's server, in a temporary folder, at a free port, ended with the test."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from helpers.isolation import free_port

_NEWEST = max(
    Path('/usr/lib/postgresql').glob('*/bin'), key=lambda each: float(each.parent.name), default=None
)
_START_S = 120


def find_programs() -> Path | None:
    """Return the folder of Postgres's programs, or None if it is not installed."""
    found = shutil.which('initdb')
    return Path(found).parent if found else _NEWEST


class Postgres:
    """A server that runs until its block ends. It refuses to run as root, so root lends it another user."""

    def __init__(self, programs: Path, folder: Path) -> None:
        self._programs = programs
        self._folder = folder
        self._user = 'postgres' if os.name == 'posix' and os.geteuid() == 0 else None
        if self._user:
            shutil.chown(folder, self._user)
        self._data = folder / 'data'
        self._port = free_port()
        self.url = f'postgresql://postgres@127.0.0.1:{self._port}/postgres'
        self._run('initdb', '-A', 'trust', '-U', 'postgres', '-D', str(self._data))

    def start(self) -> None:
        """Start the server, and wait until it takes connections."""
        options = f'-p {self._port} -k {self._folder} -c listen_addresses=127.0.0.1 -c max_connections=300'
        log = str(self._folder / 'log')
        self._run('pg_ctl', 'start', '-w', '-D', str(self._data), '-l', log, '-o', options)

    def stop(self, mode: str = 'fast') -> None:
        """End the server: 'fast' breaks connections off, 'immediate' is what a crash leaves behind."""
        self._run('pg_ctl', 'stop', '-w', '-D', str(self._data), '-m', mode)

    def _run(self, program: str, *arguments: str) -> None:
        with (self._folder / 'commands').open('a') as log:
            subprocess.run(
                [self._programs / program, *arguments],
                user=self._user,
                group=self._user,
                cwd=self._folder,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                timeout=_START_S,
                check=True,
            )


@contextmanager
def postgres(programs: Path) -> Iterator[Postgres]:
    """Run a server."""
    with TemporaryDirectory(prefix='postgres-') as folder:
        server = Postgres(programs, Path(folder))
        server.start()
        try:
            yield server
        finally:
            server.stop('immediate')
