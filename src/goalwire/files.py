"""Reading files that others wrote: no named pipe hangs, and no endless or huge file fills the memory.

And where files of one's own go that can be made again.

The import hook uses it, so it imports nothing that Python has not loaded at its start.
"""

import errno
import os
import stat

TYPE_CHECKING = False  # typing would cost 5 ms
if TYPE_CHECKING:
    from collections.abc import Callable

LARGEST_DEFINITION = 2**20
"""Bytes that a definition or a package.xml may have; the largest of ROS 2 itself have a hundredth of it."""
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
    """Return what a regular file holds.

    Raises OSError, whose strerror says what is wrong, also for anything but a regular file and for one of
    more than `largest` bytes.
    """
    _refuse_special(path, os.stat(path).st_mode)  # before it is opened: opening a device may do something
    descriptor = os.open(path, _FLAGS)  # a pipe that took its place meanwhile does not block
    with open(descriptor, 'rb', buffering=0) as stream:
        found = os.fstat(descriptor)
        _refuse_special(path, found.st_mode)
        if found.st_size > largest:
            raise _too_large(path, largest)
        return _read(stream.read, path, largest)


def why_others_write(state: os.stat_result) -> str:
    """Return why other users can change what lies in a folder, '' if they cannot; Windows is not judged.

    Folders of root are as good as one's own. So is a folder that its group may write to, if the group is the
    user's own and has no other members: systems with such groups make new folders so.
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
    except KeyError:  # a container's user without a name: the groups of single users have their numbers
        return uid == gid
    return group.gr_name == user and set(group.gr_mem) <= {user}


def cache_folder(name: str) -> str:
    """Return the user's own folder for what can be made again. Raises OSError if the user has no home."""
    return _own_folder('XDG_CACHE_HOME', '.cache', name)


def state_folder(name: str) -> str:
    """Return the user's own folder for what must be kept. Raises OSError if the user has no home."""
    return _own_folder('XDG_STATE_HOME', os.path.join('.local', 'state'), name)


def _own_folder(variable: str, otherwise: str, name: str) -> str:
    own = os.environ.get('LOCALAPPDATA' if os.name == 'nt' else variable, '')
    base = own if os.path.isabs(own) else os.path.join(os.path.expanduser('~'), otherwise)
    if not os.path.isabs(base):
        raise OSError(errno.ENOENT, 'the user has no home', base)
    return os.path.join(base, 'goalwire', name)


def shown(path: str, longest: int = 500) -> str:
    """Return a path as messages show it: on one line, without control characters, not endless."""
    text = ''.join(sign if sign.isprintable() else sign.encode('unicode_escape').decode() for sign in path)
    return text if len(text) <= longest else f'{text[: longest // 2]}…{text[-longest // 2 :]}'


def _read(read: 'Callable[[int], bytes | None]', path: str, largest: int) -> bytes:
    """Read to the end: files of /proc, and those that grow meanwhile, hold more than their size says."""
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
