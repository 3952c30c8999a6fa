"""A session of goalwire's that shares memory: own_side.py ROLE ADDRESS COUNT [LOCKABLE [all]]

ROLE is `subscriber`, which counts what came whole, or `publisher`, which sends without end if COUNT is 0.
With LOCKABLE the user `nobody` runs it, who may lock so many KiB in memory. It shares memory with its own
kind, with `all` also with eclipse-zenoh.
"""

import sys
import threading
import zlib
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from itertools import count
from pkgutil import iter_modules
from random import Random

from nobody import become_nobody

from goalwire.zenoh.io import shared_memory
from goalwire.zenoh.io.dialler import Retry
from goalwire.zenoh.io.native_session import NativeSession
from goalwire.zenoh.io.settings import MemorySettings, Settings
from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.publication import Publication

SIZES = (10, 3000, 70_000, 200_000, 1_000_000)
MEMORY = MemorySettings(with_own=True, least=1024, pool_size=16 << 20)


def receive(session: NativeSession, most: int) -> None:
    """Count messages, torn ones and gaps, and tell after `most`; each publisher counts from 0."""
    came: list[int] = []
    torn: list[int] = []
    gaps: list[int] = []
    ended = threading.Event()

    def take(sample: Sample) -> None:
        data = bytes(sample.payload or b'')
        number = int.from_bytes(data[:4], 'little')
        if zlib.crc32(data[8:]) != int.from_bytes(data[4:8], 'little'):
            torn.append(number)
        if came and number not in {0, came[-1] + 1}:
            gaps.append(number)
        came.append(number)
        if len(came) == 1:
            print('first', flush=True)
        if len(came) == most:
            ended.set()

    session.protocol.declare_subscriber('test/shared', take)
    print('ready', flush=True)
    ended.wait(300)
    print(f'received {len(came)} torn {len(torn)} gaps {len(gaps)}', flush=True)


def send(session: NativeSession, most: int) -> None:
    publication = Publication(session.protocol, 'test/shared', droppable=False)
    while not any(link.peer.subscribers.has_meeting('test/shared') for link in session.protocol.links):
        session.wait_until(lambda: False, 0.01)
    print('ready', flush=True)
    random = Random(most)
    for number in count() if not most else range(most):
        body = random.randbytes(random.choice(SIZES))
        publication.put(number.to_bytes(4, 'little') + zlib.crc32(body).to_bytes(4, 'little') + body)
    print('sent', flush=True)


def load_all() -> None:
    """Import what a session imports when it first needs it: nobody may not be allowed to read it."""
    for name in ('atomicshm', 'ctypes', 'fcntl', 'mmap', 'traceback'):
        if find_spec(name):
            import_module(name)
    for module in iter_modules(shared_memory.__path__, f'{shared_memory.__name__}.'):
        import_module(module.name)
    NativeSession(Settings(memory=MEMORY)).close()


def main() -> None:
    role, where, most, *options = sys.argv[1:]
    listens = role == 'subscriber'
    if options:
        load_all()
        become_nobody(int(options[0]))
    session = NativeSession(
        Settings(
            listen=(where,) if listens else (),
            connect=() if listens else (where,),
            memory=replace(MEMORY, with_all='all' in options),
            retry=Retry(0.05, 0.2),
        )
    )
    (receive if listens else send)(session, int(most))
    sys.stdin.readline()
    session.close()


main()
