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


CABLE = 'cable'
"""The name of each machine's network device."""


class Machine:
    """A namespace with one address."""

    def __init__(self, name: str, address: str) -> None:
        self.name = name
        self.address = address

    def run(self, file: Path, *arguments: str, env: Mapping[str, str], cwd: Path | None = None) -> Program:
        """Run a Python program on this machine."""
        return Program(_JOIN, self.name, str(file), *arguments, env=env, cwd=cwd)

    def switch(self, state: str) -> None:
        """Switch the network device 'up' or 'down'."""
        _ip('-n', self.name, 'link', 'set', CABLE, state)

    def add_address(self, address: str, bits: int = 24, device: str = CABLE) -> None:
        """Give a device one more address, of IPv4 or IPv6."""
        at_once = ('nodad',) if ':' in address else ()
        _ip('-n', self.name, 'address', 'add', f'{address}/{bits}', 'dev', device, *at_once)

    def remove_address(self, address: str, bits: int = 24) -> None:
        """Take an address from the cable's device."""
        _ip('-n', self.name, 'address', 'delete', f'{address}/{bits}', 'dev', CABLE)

    def add_device(self, device: str, address: str) -> None:
        """Add a network device with an address, which leads nowhere."""
        end = ('peer', 'name', f'{device}-end')
        _ip('-n', self.name, 'link', 'add', device, 'type', 'veth', *end)
        _ip('-n', self.name, 'link', 'set', device, 'up')
        self.add_address(address, device=device)

    def remove_device(self, device: str) -> None:
        """Take a network device away."""
        _ip('-n', self.name, 'link', 'delete', device)


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
    with machines_without_cable(first, second) as (a, b):
        _ip('link', 'add', CABLE, 'netns', a.name, 'type', 'veth', 'peer', 'name', CABLE, 'netns', b.name)
        for machine in (a, b):
            _set_up(machine)
        yield a, b


@contextmanager
def machines_without_cable(first: str, second: str) -> Iterator[tuple[Machine, Machine]]:
    """Make two machines that are to have these addresses; raises CalledProcessError."""
    a, b = (Machine(f'goalwire-{os.getpid()}-{side}', it) for side, it in (('a', first), ('b', second)))
    try:
        for machine in (a, b):
            _ip('netns', 'add', machine.name)
        yield a, b
    finally:
        for machine in (a, b):
            with suppress(subprocess.CalledProcessError):
                _ip('netns', 'delete', machine.name)


def plug_in(machine: Machine, device: str) -> None:
    """Give a machine a network device of this one, as the end of its cable."""
    _ip('link', 'set', device, 'netns', machine.name)
    _ip('-n', machine.name, 'link', 'set', device, 'name', CABLE)
    _set_up(machine)


def _set_up(machine: Machine) -> None:
    inside = ('-n', machine.name)
    _ip(*inside, 'link', 'set', 'lo', 'up')
    _ip(*inside, 'address', 'add', f'{machine.address}/24', 'dev', CABLE)
    _ip(*inside, 'link', 'set', CABLE, 'up')


def _ip(*arguments: str) -> None:
    subprocess.run(['ip', *arguments], check=True, capture_output=True, timeout=20)
