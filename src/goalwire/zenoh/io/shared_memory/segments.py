"""Segments: files in /dev/shm that their owner locks as long as it lives.

The file of a segment is named by a random number, '1234.zenoh', and only its user may open it. The owner
holds a shared lock. A process that gets the exclusive lock knows that the owner has ended. All Zenoh
processes remove such files when they start.
"""

from __future__ import annotations

import os
import stat
import sys
from contextlib import suppress
from mmap import ACCESS_READ, ACCESS_WRITE, mmap
from weakref import finalize

FOLDER = '/dev/shm'  # noqa: S108 - where POSIX has it
SUFFIX = '.zenoh'
IS_SUPPORTED = sys.platform == 'linux' and os.path.isdir(FOLDER)  # noqa: PTH112 - pathlib costs 4 ms of a start
"""True if this system supports segments: locked files in /dev/shm. Other systems send bytes only."""
MOST_SWEPT = 10_000
"""The most file names that a sweep checks."""
_TRIES = 100


def path_of(number: int) -> str:
    """Return the file of a segment."""
    return f'{FOLDER}/{number}{SUFFIX}'


class OwnSegment:
    """A segment of this session's, mapped and locked. Raises OSError without room or permission.

    It is unlocked when it is closed or garbage collected.
    """

    def __init__(self, size: int, bits: int) -> None:
        """`bits` is the size of the segment's number. Pages are allocated now: so writing never fails."""
        self.size = size
        self.number, fd = _create(bits)
        self._inode = os.fstat(fd).st_ino
        self._close = finalize(self, os.close, fd)
        self._close.atexit = False
        try:
            os.posix_fallocate(fd, 0, size)
            self.map = mmap(fd, size, access=ACCESS_WRITE)
        except BaseException:
            self.unlink()
            self._close()
            raise

    def close(self) -> None:
        """Remove the segment. Readers that have it open can still read it."""
        self.unlink()
        self.abandon()

    def abandon(self) -> None:
        """Close the descriptor and the mapping only: in a forked child the segment is the parent's."""
        _unmap(self.map)
        self._close()

    def unlink(self) -> None:
        """Remove the segment's name; the lock stays."""
        with suppress(OSError):
            path = path_of(self.number)
            if os.stat(path).st_ino == self._inode:  # noqa: PTH116
                os.unlink(path)  # noqa: PTH108


def _create(bits: int) -> tuple[int, int]:
    """Return the number and descriptor of a new segment, which is locked."""
    import fcntl

    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC | os.O_NOFOLLOW
    for _ in range(_TRIES):
        number = int.from_bytes(os.urandom(bits // 8), 'little')
        try:
            fd = os.open(path_of(number), flags, 0o600)
        except FileExistsError:
            continue
        try:
            fcntl.flock(fd, fcntl.LOCK_SH | fcntl.LOCK_NB)
            if os.fstat(fd).st_nlink:
                return number, fd
        except BlockingIOError:  # a sweep of another process takes the new file for an orphan
            pass
        os.close(fd)
    raise OSError(f'no free name for shared memory after {_TRIES} tries')


class ForeignSegment:
    """An open segment of another process; its content may change at any time. Raises OSError.

    It is closed once by `close`, whichever threads call it, or as it is garbage collected.
    """

    def __init__(self, number: int, *, writable: bool = False) -> None:
        flags = (os.O_RDWR if writable else os.O_RDONLY) | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK
        self.number = number
        self._is_writable = writable
        self._map: mmap | None = None
        self.fd = os.open(path_of(number), flags)
        self._close = finalize(self, _close_in, os.getpid(), self.fd)
        self._close.atexit = False
        found = os.fstat(self.fd)
        if not stat.S_ISREG(found.st_mode) or found.st_uid != os.geteuid():
            self._close()
            raise OSError(f'segment {number} is not a file of this user')
        self.size = found.st_size
        self._inode = found.st_ino

    @property
    def map(self) -> mmap:
        """The mapping of the whole segment, made at its first use. Raises ValueError if it is closed."""
        if self._map is None:
            if self.fd < 0:
                raise ValueError(f'segment {self.number} is closed')
            self._map = mmap(self.fd, self.size, access=ACCESS_WRITE if self._is_writable else ACCESS_READ)
        return self._map

    def read(self, size: int, offset: int) -> bytes:
        """Return a copy of `size` bytes at `offset`, fewer at the segment's end."""
        return os.pread(self.fd, size, offset)

    def is_current(self) -> bool:
        """True if the name still leads to this file, or to none because the owner has ended."""
        try:
            return os.stat(path_of(self.number)).st_ino == self._inode  # noqa: PTH116
        except OSError:
            return True

    def has_owner(self) -> bool:
        """True while a process holds the lock: the owner or another one."""
        import fcntl

        try:
            fcntl.flock(self.fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:
            return False
        fcntl.flock(self.fd, fcntl.LOCK_UN)
        return False

    def close(self) -> None:
        """Close the segment. Views of it stay valid."""
        mapped, self._map, self.fd = self._map, None, -1
        if mapped is not None:
            _unmap(mapped)
        self._close()


def _close_in(process: int, fd: int) -> None:
    """Close a descriptor in the process that opened it; in a forked child it may be another file's by now."""
    if os.getpid() == process:
        os.close(fd)


def _unmap(mapped: mmap) -> None:
    with suppress(BufferError):  # a view exists: the mapping ends with the last view
        mapped.close()


def sweep() -> int:
    """Remove the segments of this user whose owners are gone; return how many."""
    import fcntl

    swept = 0
    with os.scandir(FOLDER) as entries:
        for looked_at, entry in enumerate(entries):
            if looked_at >= MOST_SWEPT:
                break
            name = entry.name.removesuffix(SUFFIX)
            if name == entry.name or not (name.isascii() and name.isdigit()):
                continue
            try:
                segment = ForeignSegment(int(name), writable=True)
            except OSError:
                continue
            try:
                fcntl.flock(segment.fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
                # under the lock, so that no other process can take the file over before it is removed
                if segment.is_current():
                    os.unlink(entry.path)  # noqa: PTH108
                    swept += 1
            except OSError:
                pass
            finally:
                segment.close()
    return swept
