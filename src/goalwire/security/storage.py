"""Writing files of a keystore, so that lost power leaves either the old file or the new one.

A file is written beside its place, brought to the disk, and then put into its place in one step of the file
system. A file that must not replace another one is put there by a hard link, which fails if the name is
taken. A failed attempt may leave a file whose name begins with a dot; such files are never read.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex

PRIVATE = 0o600
PUBLIC = 0o644
FOLDER = 0o700


def _write_beside(path: Path, data: bytes, mode: int) -> Path:
    """Write a new file in the folder of `path`, and return its own path."""
    beside = path.with_name(f'.{path.name}.{token_hex(4)}')
    # The mode is set at creation: a key is never readable by others, not even for a moment.
    descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    with os.fdopen(descriptor, 'wb') as stream:
        stream.write(data)
        stream.flush()
        os.fsync(descriptor)
    return beside


def _bring_to_disk(folder: Path) -> None:
    """Flush the names in a folder to the disk; Windows has no such call for folders."""
    if os.name != 'posix':
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def create(path: Path, data: bytes, mode: int = PRIVATE) -> None:
    """Write a file that is not there yet. Raises FileExistsError, and leaves that file as it is."""
    beside = _write_beside(path, data, mode)
    try:
        os.link(beside, path)
    finally:
        beside.unlink()
    _bring_to_disk(path.parent)


def replace(path: Path, data: bytes, mode: int = PRIVATE) -> None:
    """Write a file, in place of the existing one if there is one."""
    beside = _write_beside(path, data, mode)
    try:
        beside.replace(path)
    except BaseException:
        with suppress(OSError):
            beside.unlink()
        raise
    _bring_to_disk(path.parent)


@contextmanager
def hold_lock(path: Path) -> Iterator[None]:
    """Lock `path` for the block, against other processes. The file is made if it is not there."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, PRIVATE)
    with os.fdopen(descriptor, 'r+b') as stream:
        try:
            import fcntl
        except ImportError:  # Windows
            pass
        else:
            fcntl.flock(stream, fcntl.LOCK_EX)  # the lock ends when `stream` is closed
        yield


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """Give the block a folder to fill, which becomes `path` at the block's end, whole or not at all.

    Raises FileExistsError if there is something at `path`, other than an empty folder.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f'.{path.name}.{token_hex(4)}')
    beside.mkdir(FOLDER)
    try:
        yield beside
        _bring_to_disk(beside)
        try:
            beside.rename(path)  # an empty folder may exist; the system refuses a full one
        except OSError as error:
            if path.exists():
                raise FileExistsError(f"'{path}' is there already") from error
            raise
    except BaseException:
        _discard(beside)
        raise
    _bring_to_disk(path.parent)


def _discard(folder: Path) -> None:
    for root, folders, files in os.walk(folder, topdown=False):
        for name in files:
            Path(root, name).unlink()
        for name in folders:
            Path(root, name).rmdir()
    with suppress(OSError):
        folder.rmdir()
