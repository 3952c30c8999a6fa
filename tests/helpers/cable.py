"""A cable between two machines that is made of faults: each Ethernet frame crosses from /a to /b, or back.

So what `goalwire.transport.faults` does to messages it does to a real network's packets, TCP and UDP alike,
where the kernel has no netem.
"""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from select import select
from threading import Thread

from helpers.machines import Machine, machines_without_cable, plug_in

from goalwire.transport.faults import Faults, Kind, Packet

if sys.platform == 'linux':
    from fcntl import ioctl

_TUNSETIFF = 0x400454CA
_TAP_WITHOUT_HEADER = 0x0002 | 0x1000
_FRAME = 65_536
_MULTICAST = b'\x01\0\x5e'
"""How a frame begins that goes to a multicast group of IPv4."""


class _End:
    """A network device of this process, which reads what is sent through it."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.file = os.open('/dev/net/tun', os.O_RDWR)
        ioctl(self.file, _TUNSETIFF, struct.pack('16sH22x', name.encode(), _TAP_WITHOUT_HEADER))

    def write(self, packet: Packet) -> None:
        """Let a frame arrive; a device that is down takes none."""
        with suppress(OSError):
            os.write(self.file, bytes(packet.payload))


def _forward(ends: tuple[_End, _End], stop: int, faults: Faults, carries_multicast: bool) -> None:
    a, b = ends
    ways = {a.file: (b, '/a', '/b'), b.file: (a, '/b', '/a')}
    while True:
        readable, _, _ = select([*ways, stop], [], [])
        if stop in readable:
            return
        for file in readable:
            target, here, there = ways[file]
            with suppress(OSError):  # the device is down
                frame = os.read(file, _FRAME)
                if not carries_multicast and frame.startswith(_MULTICAST):
                    continue
                faults.send(Packet(Kind.MESSAGE, 'frame', here, there, frame), target.write)


@contextmanager
def cabled_machines(
    first: str, second: str, faults: Faults, *, carries_multicast: bool = True
) -> Iterator[tuple[Machine, Machine]]:
    """Make two machines with these addresses, called /a and /b by `faults`, which are their cable's."""
    with ExitStack() as stack:
        machines = stack.enter_context(machines_without_cable(first, second))
        ends = _End(f'gw{os.getpid()}a'), _End(f'gw{os.getpid()}b')
        for end in ends:
            stack.callback(os.close, end.file)
        for machine, end in zip(machines, ends, strict=True):
            plug_in(machine, end.name)
        stopped, stop = os.pipe()
        stack.callback(os.close, stopped)
        thread = Thread(target=_forward, args=(ends, stopped, faults, carries_multicast), name='cable')
        thread.start()
        stack.callback(faults.discard)
        stack.callback(thread.join)
        stack.callback(os.close, stop)
        yield machines


def can_make_cables() -> bool:
    """Whether this process may make such machines and cables."""
    if not Path('/dev/net/tun').exists():
        return False
    try:
        with cabled_machines('192.0.2.1', '192.0.2.2', Faults()):
            return True
    except (OSError, ValueError):
        return False
