"""The audit log of an identity: one line of JSON for each refusal, chained by hashes.

Each line holds the SHA-256 of the line before it. So a line that was changed, taken out, or put in is found,
unless all that follow it are written anew, or it was the last. Against that a copy elsewhere helps.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import BinaryIO

from goalwire.errors import SecurityError
from goalwire.files import read_regular
from goalwire.security.storage import FOLDER, PRIVATE

BEGIN = '0' * 64
"""Stands in the first line for the hash of the line before it."""
LARGEST = 1 << 26
"""The largest size of a log: nothing more is written beyond it, nor read."""
_TAIL = 1 << 16
"""Bytes at the end of a file in which its last line begins."""


def log_path(folder: Path, name: str) -> Path:
    """Return the file of an identity's log, in its keystore."""
    return folder / 'audit' / f'{name}.log'


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    """Open a log and lock out other processes: several programs may have one identity."""
    path.parent.mkdir(FOLDER, exist_ok=True)
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, PRIVATE)
    with os.fdopen(descriptor, 'r+b') as stream:
        try:
            import fcntl
        except ImportError:  # Windows
            pass
        else:
            fcntl.flock(stream, fcntl.LOCK_EX)  # the end of the file is the end of the lock
        yield stream


def append(path: Path, *entries: Mapping[str, str]) -> None:
    """Write entries, each with the hash of the line before it, and bring them to the disk.

    Raises OSError, also if the log is full.
    """
    with _opened(path) as log:
        size = log.seek(0, os.SEEK_END)
        if size > LARGEST - _TAIL:
            raise OSError(None, f"'{path}' is full: move it elsewhere")
        log.seek(max(0, size - _TAIL))
        lines = log.read().splitlines(keepends=True)
        torn = b'' if not lines or lines[-1].endswith(b'\n') else b'\n'  # lost power: its rest is kept
        before = _hash(lines[-1].rstrip(b'\n')) if lines else BEGIN
        log.write(torn)
        for entry in entries:
            line = json.dumps({**entry, 'before': before}).encode()
            log.write(line + b'\n')
            before = _hash(line)
        log.flush()
        os.fsync(log.fileno())


def _hash(line: bytes) -> str:
    return sha256(line).hexdigest()


def read(path: Path) -> Iterator[dict[str, str]]:
    """Yield the entries of a log, oldest first. Raises SecurityError at the first line that does not fit."""
    try:
        content = read_regular(os.fspath(path), LARGEST)
    except OSError as error:
        raise SecurityError(f"'{path}' cannot be read: {error.strerror or error}") from None
    before = BEGIN
    for number, line in enumerate(content.splitlines(), 1):
        try:
            entry = json.loads(line)
        except ValueError:
            entry = None
        if not isinstance(entry, dict):
            raise SecurityError(f'{path}:{number}: this line is damaged')
        if entry.pop('before', None) != before:
            raise SecurityError(
                f'{path}:{number}: the line before this one was changed, taken out, or put in'
            )
        yield {str(name): str(value) for name, value in entry.items()}
        before = _hash(line)
