"""Two machines and a cable, as network namespaces of Linux: for what loopback cannot show. Needs root."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from helpers.processes import Program

_JOIN = """
    import ctypes, os, sys

    namespace = os.open(f'/run/netns/{sys.argv[1]}', os.O_RDONLY)
    if ctypes.CDLL(None, use_errno=True).setns(namespace, 0x40000000):  # CLONE_NEWNET
        raise OSError(ctypes.get_errno(), 'setns')
    os.execv(sys.executable, [sys.executable, *sys.argv[2:]])
"""


class Machine:
    """A namespace with one address."""

    def __init__(self, name: str, address: str) -> None:
        self.name = name
        self.address = address

    def run(self, file: Path, *arguments: str, env: Mapping[str, str], cwd: Path | None = None) -> Program:
        """Run a Python program on this machine."""
        return Program(_JOIN, self.name, str(file), *arguments, env=env, cwd=cwd)


def can_make_machines() -> bool:
    """Whether this process may make network namespaces."""
    if sys.platform != 'linux' or os.geteuid() != 0 or shutil.which('ip') is None:
        return False
    try:
        with two_machines('192.0.2.1', '192.0.2.2'):
            return True
    except subprocess.CalledProcessError:
        return False


@contextmanager
def two_machines(first: str, second: str) -> Iterator[tuple[Machine, Machine]]:
    """Make two machines with these addresses and a cable between them; raises CalledProcessError."""
    machines = [Machine(f'goalwire-{os.getpid()}-{side}', it) for side, it in (('a', first), ('b', second))]
    try:
        for machine in machines:
            _ip('netns', 'add', machine.name)
        a, b = machines
        _ip('link', 'add', 'cable', 'netns', a.name, 'type', 'veth', 'peer', 'name', 'cable', 'netns', b.name)
        for machine in machines:
            inside = ('-n', machine.name)
            _ip(*inside, 'link', 'set', 'lo', 'up')
            _ip(*inside, 'address', 'add', f'{machine.address}/24', 'dev', 'cable')
            _ip(*inside, 'link', 'set', 'cable', 'up')
        yield a, b
    finally:
        for machine in machines:
            with suppress(subprocess.CalledProcessError):
                _ip('netns', 'delete', machine.name)


def _ip(*arguments: str) -> None:
    subprocess.run(['ip', *arguments], check=True, capture_output=True, timeout=20)
