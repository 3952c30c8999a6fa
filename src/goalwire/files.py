"""Reads files that others wrote, without hanging on a named pipe or filling the memory with a huge file.

Also says in which folders goalwire's own files are, and leads an output that nobody can read to nowhere.

The import hook uses this module. So it imports only modules that Python has already loaded at its start.
"""

import errno
import os
import stat

TYPE_CHECKING = False  # not from typing, whose import takes 5 ms
if TYPE_CHECKING:
    from collections.abc import Callable

LARGEST_DEFINITION = 2**20
"""The largest size in bytes of a definition or package.xml; ROS 2's own files have at most a hundredth
of it.
"""
LARGEST_PARAMETER_FILE = 2**24

_KINDS = {
    stat.S_IFDIR: 'a folder',
    stat.S_IFIFO: 'a named pipe',
    stat.S_IFSOCK: 'a socket',
    stat.S_IFCHR: 'a device',
    stat.S_IFBLK: 'a device',
}
_FLAGS = os.O_RDONLY | getattr(os, 'O_NONBLOCK', 0) | getattr(os, 'O_CLOEXEC', 0) | getattr(os, 'O_BINARY', 0)


def read_regular(path: str, largest: int) -> bytes:
    """Return the content of a regular file.

    Raises OSError, whose strerror says what is wrong, also for anything but a regular file, and for a file of
    more than `largest` bytes.
    """
    _refuse_special(path, os.stat(path).st_mode)  # before the opening, which may have an effect on a device
    descriptor = os.open(path, _FLAGS)  # O_NONBLOCK: a pipe in its place does not block
    with open(descriptor, 'rb', buffering=0) as stream:
        found = os.fstat(descriptor)
        _refuse_special(path, found.st_mode)
        if found.st_size > largest:
            raise _too_large(path, largest)
        return _read(stream.read, path, largest)


def discard_output(descriptor: int) -> None:
    """Lead an output of this process to the null device: everything written to it from now on is dropped.

    For standard output whose reader has gone, or whose disk is full: Python writes the rest at its exit, and
    would fail there once more.
    """
    null = os.open(os.devnull, os.O_WRONLY)
    if null != descriptor:  # equal if the output was closed
        os.dup2(null, descriptor)
        os.close(null)


def why_others_write(state: os.stat_result) -> str:
    """Return a reason why other users can change the content of a folder; '' if they cannot, and on Windows.

    Folders of root are trusted like the user's own. A folder that its group may write to is trusted if the
    group is the user's own and has no other members: systems with such groups give new folders these
    permissions.
    """
    if os.name != 'posix':
        return ''
    if state.st_uid not in (0, os.geteuid()):
        return 'it belongs to another user'
    if state.st_mode & stat.S_IWOTH:
        return 'everybody may write to it'
    if state.st_mode & stat.S_IWGRP and not _is_own_group(state.st_gid):
        return 'its group may write to it'
    return ''


def _is_own_group(gid: int) -> bool:
    import grp
    import pwd

    uid = os.geteuid()
    try:
        user, group = pwd.getpwuid(uid).pw_name, grp.getgrgid(gid)
    except KeyError:  # a container's user without a name: its own group has the user's number
        return uid == gid
    return group.gr_name == user and set(group.gr_mem) <= {user}


def cache_folder(name: str) -> str:
    """Return the user's folder for goalwire's files that can be made again. Raises OSError without a home."""
    return _own_folder('XDG_CACHE_HOME', '.cache', name)


def state_folder(name: str) -> str:
    """Return the user's folder for goalwire's files that must be kept. Raises OSError without a home."""
    return _own_folder('XDG_STATE_HOME', os.path.join('.local', 'state'), name)


def _own_folder(variable: str, otherwise: str, name: str) -> str:
    own = os.environ.get('LOCALAPPDATA' if os.name == 'nt' else variable, '')
    base = own if os.path.isabs(own) else os.path.join(os.path.expanduser('~'), otherwise)
    if not os.path.isabs(base):
        raise OSError(errno.ENOENT, 'the user has no home', base)
    return os.path.join(base, 'goalwire', name)


def show(path: str, longest: int = 500) -> str:
    """Return a path as error texts show it: on one line, without control characters, at most `longest`
    characters.
    """
    text = ''.join(sign if sign.isprintable() else sign.encode('unicode_escape').decode() for sign in path)
    return text if len(text) <= longest else f'{text[: longest // 2]}…{text[-longest // 2 :]}'


def _read(read: 'Callable[[int], bytes | None]', path: str, largest: int) -> bytes:
    """Read a file to its end: files of /proc, and files that grow meanwhile, contain more than their size
    says.
    """
    parts: list[bytes] = []
    left = largest + 1
    while left > 0 and (part := read(left)):
        parts.append(part)
        left -= len(part)
    if left <= 0:
        raise _too_large(path, largest)
    return b''.join(parts)


def _refuse_special(path: str, mode: int) -> None:
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), 'something else')
        raise OSError(errno.EINVAL, f'it is {kind}, not a regular file', path)


def _too_large(path: str, largest: int) -> OSError:
    return OSError(errno.EFBIG, f'it has more than {largest:,} bytes', path)
