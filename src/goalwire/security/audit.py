"""The audit log of an identity: one line of JSON for each refusal, chained by hashes.

Each line holds the SHA-256 of the line before it. So a changed, removed or inserted line is detected,
unless all later lines were rewritten, or the line was the last. A copy of the log in another place protects
against that.

A log that has grown large is put aside as NAME.log.1, the next one as NAME.log.2, and so on. The first line
of each holds the hash of the last line of the one before it. If there are more than KEPT such logs, the
oldest is deleted.
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
"""The first line of all has this in place of the hash of an earlier line."""
PUT_ASIDE_AT = 1 << 22
"""The size at which a log is put aside, in bytes: some 15,000 entries."""
KEPT = 15
"""How many old logs are kept: with the current one, 64 MiB for each identity."""
_LARGEST = 1 << 26
"""The largest size of one log file, in bytes: above PUT_ASIDE_AT, since entries that are written together go
into one file.
"""
_TAIL = 1 << 16
"""The last line of a file begins within this many bytes of its end."""


def log_path(folder: Path, name: str) -> Path:
    """Return the file of an identity's log, in its keystore."""
    return folder / 'audit' / f'{name}.log'


def put_aside(path: Path) -> dict[int, Path]:
    """Return the logs that were put aside, by number, the oldest first."""
    found = {
        int(each.suffix[1:]): each
        for each in path.parent.glob(f'{path.name}.*')
        if each.suffix[1:].isascii() and each.suffix[1:].isdigit()
    }
    return dict(sorted(found.items()))


@contextmanager
def _open_locked(path: Path) -> Iterator[BinaryIO]:
    """Open a log with an exclusive lock: several programs may have one identity."""
    path.parent.mkdir(FOLDER, exist_ok=True)
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, PRIVATE)
        with os.fdopen(descriptor, 'r+b') as stream:
            try:
                import fcntl
            except ImportError:  # Windows
                pass
            else:
                fcntl.flock(stream, fcntl.LOCK_EX)  # closing the file releases the lock
                if not _is_at(stream, path):  # another process has put the log aside meanwhile
                    continue
            yield stream
            return


def _is_at(stream: BinaryIO, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(stream.fileno()), path.stat())
    except FileNotFoundError:
        return False


def append(path: Path, *entries: Mapping[str, str]) -> None:
    """Write entries, each with the hash of the line before it, and bring them to the disk. Raises OSError."""
    while True:
        with _open_locked(path) as log:
            if log.seek(0, os.SEEK_END) < PUT_ASIDE_AT:
                _write(log, path, entries)
                return
            _put_aside(path)


def _write(log: BinaryIO, path: Path, entries: tuple[Mapping[str, str], ...]) -> None:
    last = _last_line(log)
    if not last:
        before = BEGIN
        for each in list(put_aside(path).values())[-1:]:
            with each.open('rb') as full:
                before = _hash(_last_line(full).rstrip(b'\n'))
    else:
        before = _hash(last.rstrip(b'\n'))
        if not last.endswith(b'\n'):  # power was lost while the line was written: its first part is kept
            log.write(b'\n')
    for entry in entries:
        line = json.dumps({**entry, 'before': before}).encode()
        log.write(line + b'\n')
        before = _hash(line)
    log.flush()
    os.fsync(log.fileno())


def _last_line(log: BinaryIO) -> bytes:
    """Return the last line of a log, empty if it has none."""
    log.seek(max(0, log.seek(0, os.SEEK_END) - _TAIL))
    return (log.read().splitlines(keepends=True) or [b''])[-1]


def _put_aside(path: Path) -> None:
    """Give a log the next number, and delete the oldest logs beyond KEPT."""
    before = put_aside(path)
    path.rename(path.with_name(f'{path.name}.{max(before, default=0) + 1}'))
    for number in list(before)[: max(0, len(before) + 1 - KEPT)]:
        before[number].unlink()


def _hash(line: bytes) -> str:
    return sha256(line).hexdigest()


def read(path: Path) -> Iterator[dict[str, str]]:
    """Yield the entries of a log and of those that were put aside, oldest first.

    Raises SecurityError at the first damaged line, or line whose hash does not match.
    """
    aside = put_aside(path)
    # The oldest entry may follow deleted ones, whose hash is unknown.
    before = '' if aside and min(aside) > 1 else BEGIN
    for file in [*aside.values(), *([path] if path.exists() or not aside else [])]:
        for number, line in enumerate(_content(file).splitlines(), 1):
            yield _entry(line, before, f'{file}:{number}')
            before = _hash(line)


def _content(file: Path) -> bytes:
    try:
        return read_regular(os.fspath(file), _LARGEST)
    except OSError as error:
        raise SecurityError(f"'{file}' cannot be read: {error.strerror or error}") from None


def _entry(line: bytes, before: str, place: str) -> dict[str, str]:
    """Return an entry; `before` is the hash of the line before it, empty if that is not known."""
    try:
        entry = json.loads(line)
    except ValueError:
        entry = None
    if not isinstance(entry, dict):
        raise SecurityError(f'{place}: this line is damaged')
    found = entry.pop('before', None)
    if before and found != before:
        raise SecurityError(f'{place}: the line before this one was changed, taken out, or put in')
    return {str(name): str(value) for name, value in entry.items()}
