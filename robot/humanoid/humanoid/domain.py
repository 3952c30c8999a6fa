"""One humanoid in a ROS domain: a program that starts a robot claims its domain first.

A claim is a locked file on this machine, which the system lets go when the process ends, however it ends;
servers that are started one by one share such a lock. A lock does not show robots of other machines and
users; a separate process (humanoid.look) searches the domain itself for their servers.
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
CLAIMED = 'HUMANOID_DOMAIN_CLAIMED'  # set for the children of the process that holds the domain
DEFAULT = '0'
LAST = 101  # in higher domains DDS uses ports that Linux gives to other programs


class Taken(Exception):
    """A humanoid is running in the domain already; the text says what to do."""


@contextmanager
def claimed(*, may_move: bool) -> Iterator[None]:
    """Hold a domain without a humanoid while the block runs. Raises Taken.

    That is the domain of ROS_DOMAIN_ID, or domain 0. If the variable is not set and `may_move`, the next
    free domain is taken and printed, and this process and its children use it.
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
    """While the block runs, keep others from claiming the domain in which this server runs."""
    if os.environ.get(CLAIMED):
        yield
        return
    lock = _open(os.environ.get(VARIABLE, '').strip() or DEFAULT)
    try:
        _locks(lock, shared=True)  # if a whole humanoid holds the lock, this server may replace one that died
        yield
    finally:
        os.close(lock)


def _first_free(given: str, *, may_move: bool) -> tuple[str, int]:
    """Return the domain to use and the file descriptor of its lock. Raises Taken."""
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
    """Lock a domain and return the descriptor; None if a humanoid is in it."""
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
    """Open the lock file of a domain and return its descriptor."""
    wire = os.environ.get('RMW_IMPLEMENTATION', '')
    user = os.getuid() if hasattr(os, 'getuid') else 0
    name = re.sub(r'\W', '_', f'humanoid_{user}_{wire}_{domain}')[:100] + '.lock'
    flags = os.O_RDWR | os.O_CREAT | getattr(os, 'O_NOFOLLOW', 0)
    return os.open(Path(tempfile.gettempdir(), name), flags, 0o600)


def _locks(descriptor: int, *, shared: bool = False) -> bool:
    """Lock the file; return False if another process holds it. On Windows no lock is shared."""
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
        stderr=subprocess.DEVNULL,  # if ROS does not work here, the servers will say so
        check=False,
    )
    return looked.returncode == SOMEBODY_IS_THERE
