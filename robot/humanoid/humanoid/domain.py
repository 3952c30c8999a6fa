"""One humanoid in a ROS domain: whoever starts one claims its domain first.

A claim is a locked file on this machine, which the system lets go when the process ends, however it ends;
servers that are started one by one share such a lock. What locks cannot tell of, other machines and other
users, is looked for in the domain itself, by a process of its own (humanoid.look).
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from humanoid.look import SOMEBODY_IS_THERE

VARIABLE = 'ROS_DOMAIN_ID'
CLAIMED = 'HUMANOID_DOMAIN_CLAIMED'  # set for the children of who holds the domain
DEFAULT = '0'
LAST = 101  # beyond it DDS' ports are in the range that Linux gives to others


class Taken(Exception):
    """A humanoid is running in the domain already; the text says what to do."""


@contextmanager
def claimed(*, may_move: bool) -> Iterator[None]:
    """Hold a domain without a humanoid while the block runs. Raises Taken.

    That is the domain of ROS_DOMAIN_ID, or domain 0. Where the variable is not set and `may_move`, the next
    domain that is free will do; it is printed, and this process and its children use it.
    """
    given = os.environ.get(VARIABLE, '').strip()
    domain, lock = _first_free(given, may_move=may_move)
    if domain != (given or DEFAULT):
        os.environ[VARIABLE] = domain
    os.environ[CLAIMED] = '1'
    try:
        yield
    finally:
        os.close(lock)


@contextmanager
def taking_part() -> Iterator[None]:
    """Keep others from claiming the domain in which one server runs, while the block runs."""
    if os.environ.get(CLAIMED):
        yield
        return
    lock = _open(os.environ.get(VARIABLE, '').strip() or DEFAULT)
    try:
        _locks(lock, shared=True)  # beside a whole humanoid it may stand in for a server that died
        yield
    finally:
        os.close(lock)


def _first_free(given: str, *, may_move: bool) -> tuple[str, int]:
    """The domain to use and the descriptor that holds it. Raises Taken."""
    wanted = given or DEFAULT
    lock = _claim(wanted)
    if lock is not None:
        return wanted, lock
    running = f'a humanoid is running already in ROS domain {wanted}'
    if given:
        raise Taken(f'{running}, which {VARIABLE} names: stop it, or choose another domain')
    if not may_move:
        raise Taken(f'{running}: stop it, or give this one a domain of its own with {VARIABLE}')
    for domain in map(str, range(int(DEFAULT) + 1, LAST + 1)):
        lock = _claim(domain)
        if lock is not None:
            print(f'{running}: this one takes {VARIABLE}={domain}', flush=True)
            return domain, lock
    raise Taken(f'{running}, and in all others up to {LAST}')


def _claim(domain: str) -> int | None:
    """The descriptor that holds a domain in which there is no humanoid; None if there is one."""
    lock = _open(domain)
    try:
        if _locks(lock) and not _somebody_is_in(domain):
            held, lock = lock, -1
            return held
        return None
    finally:
        if lock >= 0:
            os.close(lock)


def _open(domain: str) -> int:
    """The descriptor of the file that stands for a domain."""
    wire = os.environ.get('RMW_IMPLEMENTATION', '')
    user = os.getuid() if hasattr(os, 'getuid') else 0
    name = re.sub(r'\W', '_', f'humanoid_{user}_{wire}_{domain}')[:100] + '.lock'
    flags = os.O_RDWR | os.O_CREAT | getattr(os, 'O_NOFOLLOW', 0)
    return os.open(Path(tempfile.gettempdir(), name), flags, 0o600)


def _locks(descriptor: int, *, shared: bool = False) -> bool:
    """False where another process holds the file; on Windows nothing is shared."""
    try:
        if sys.platform == 'win32':
            import msvcrt

            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            how = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
            fcntl.flock(descriptor, how | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _somebody_is_in(domain: str) -> bool:
    looked = subprocess.run(
        [sys.executable, '-m', 'humanoid.look'],
        env={**os.environ, VARIABLE: domain},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,  # what is wrong with ROS here, the servers will say
        check=False,
    )
    return looked.returncode == SOMEBODY_IS_THERE
