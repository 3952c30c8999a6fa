"""The folders below which package.xml files are searched: the working directory and the program's folder.

A working directory is *trusted* if Python itself imports from it (`python -c`, `python -m`, a notebook,
PYTHONPATH), or if the running program lies in its tree. Any other directory may belong to a stranger, above
all if an installed command such as `ros2` is started in /tmp. Below it the walk does not enter folders that
other users can write to, and one line on standard error names each package that is used, and its place.
"""

import os
import sys

from goalwire.files import show
from goalwire.idl import workspace

WORKING_DIRECTORY = 'the working directory'
INSTALLED = frozenset({'site-packages', 'dist-packages'})
_walks: dict[tuple[str, bool], workspace.Workspace] = {}
_warned: set[str] = set()
_told: set[str] = set()


class Root:
    """A folder to search, its name in messages, and whether the folder's tree is trusted."""

    __slots__ = ('folder', 'place', 'trusted')

    def __init__(self, place: str, folder: str, *, trusted: bool) -> None:
        self.place = place
        self.folder = folder
        self.trusted = trusted


def find_roots() -> list[Root]:
    """Return the working directory and the program's folder, if they exist; once if they are the same."""
    program = _program_folder()
    roots = []
    try:
        here = os.getcwd()
    except OSError:  # the working directory was removed meanwhile
        here = None
    if here is not None:
        trusted = _lies_in_tree(program, here) or _is_on_python_path(here)
        roots.append(Root(WORKING_DIRECTORY, here, trusted=trusted))
    if program is not None and program != here:
        roots.append(Root("the program's folder", program, trusted=True))
    return roots


def walk(root: Root) -> workspace.Workspace:
    """Return what a walk below a root finds, walking only once until `discard`.

    Warns once of each unusable package.xml.
    """
    key = root.folder, root.trusted
    if key not in _walks:
        found = _walks[key] = workspace.scan(root.folder, guarded=not root.trusted)
        for remark in found.unusable:
            warn_once(remark)
    return _walks[key]


def recall_walk(root: Root) -> workspace.Workspace | None:
    """Return what an earlier walk below a root has found; None if there was no walk."""
    return _walks.get((root.folder, root.trusted))


def tell_origin(package: str, folder: str) -> None:
    """Report once, on standard error, that a package comes from an untrusted working directory."""
    if package in _told or sys.stderr is None:
        return
    _told.add(package)
    sys.stderr.write(
        f'note: the package {package} is taken from {show(folder)}, below the working directory\n'
    )


def warn_once(text: str) -> None:
    """Issue a warning with this text once, since a repeated search finds the same problem again."""
    if text in _warned:
        return
    _warned.add(text)
    import warnings

    warnings.warn(text, RuntimeWarning, stacklevel=2)


def discard() -> None:
    """Forget all walks; the next call of `walk` searches again."""
    _walks.clear()


def _program_folder() -> str | None:
    """Return the folder of the script that Python runs; None without a script, or if it is installed."""
    for name in ('__mp_main__', '__main__'):  # multiprocessing's spawned processes have __mp_main__
        file = getattr(sys.modules.get(name), '__file__', None)
        if isinstance(file, str) and os.path.isabs(file):
            folder = os.path.dirname(os.path.normpath(file))
            installed = folder == os.path.dirname(sys.executable) or INSTALLED & set(folder.split(os.sep))
            return None if installed else folder
    return None


def _lies_in_tree(program: str | None, root: str) -> bool:
    """Return whether a program's folder is the root, or below it in a folder that is searched."""
    if program is None:
        return False
    if program == root:
        return True
    above = root if root.endswith(os.sep) else root + os.sep
    way = program[len(above) :].split(os.sep)
    return program.startswith(above) and not any(name[0] == '.' or name in workspace.IGNORED for name in way)


def _is_on_python_path(folder: str) -> bool:
    entries: list[object] = list(sys.path)
    return any(isinstance(entry, str) and (entry in ('', '.') or entry == folder) for entry in entries)
