"""Keeps a ROS domain to one humanoid: a program that starts a robot claims its domain first.

A claim is a locked file on this machine; the operating system releases the lock when the process ends,
however it ends. Servers that are started one by one share such a lock. A lock does not show robots of other
machines and users, so a separate process (humanoid.domain_search) searches the domain for their servers.
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

from humanoid.domain_search import SOMEBODY_IS_THERE

VARIABLE = 'ROS_DOMAIN_ID'
CLAIMED = 'HUMANOID_DOMAIN_CLAIMED'  # environment variable: the parent process holds the domain
DEFAULT = '0'
LAST = 101  # the highest usable domain: above it DDS uses ports that Linux gives to other programs


class Taken(Exception):
    """A humanoid is running in the domain already; the text says what to do."""


@contextmanager
def claim_domain(*, may_move: bool) -> Iterator[None]:
    """Claim a domain in which no humanoid runs, while the block runs. Raises Taken.

    The domain is that of ROS_DOMAIN_ID, or 0. If it is taken, the variable is not set and `may_move` is true,
    the next free domain is claimed and printed, and this process and its children use it.
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
    """While the block runs, keep other programs from claiming this server's domain for a humanoid."""
    if os.environ.get(CLAIMED):
        yield
        return
    lock = _open(os.environ.get(VARIABLE, '').strip() or DEFAULT)
    try:
        # Fails if `humanoid up` holds the lock. That is fine: this server may replace one that died.
        _locks(lock, shared=True)
        yield
    finally:
        os.close(lock)


def _first_free(given: str, *, may_move: bool) -> tuple[str, int]:
    """Return the domain to use, `given` if it is not '', and its lock's file descriptor. Raises Taken."""
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
    """Lock a domain and return the lock's file descriptor; None if a humanoid runs in the domain."""
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
    """Open the lock file of a domain and return its file descriptor."""
    wire = os.environ.get('RMW_IMPLEMENTATION', '')
    user = os.getuid() if hasattr(os, 'getuid') else 0
    name = re.sub(r'\W', '_', f'humanoid_{user}_{wire}_{domain}')[:100] + '.lock'
    flags = os.O_RDWR | os.O_CREAT | getattr(os, 'O_NOFOLLOW', 0)
    return os.open(Path(tempfile.gettempdir(), name), flags, 0o600)


def _locks(descriptor: int, *, shared: bool = False) -> bool:
    """Lock the file; return False if another process has locked it. On Windows a lock cannot be shared."""
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
        [sys.executable, '-m', 'humanoid.domain_search'],
        env={**os.environ, VARIABLE: domain},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,  # errors of ROS are not shown here: the robot's servers will report them
        check=False,
    )
    return looked.returncode == SOMEBODY_IS_THERE
