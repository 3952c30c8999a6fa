"""Finds interface packages in a source tree, as colcon does: by their package.xml.

The walk goes level by level, at most LEVELS down and through at most FOLDERS folders, so that an import
from a home directory stays cheap. It is used by the import hook: nothing heavy is imported here.
"""

import os

KINDS = ('msg', 'srv', 'action')
LEVELS = 4
FOLDERS = 1000
IGNORED = frozenset({'build', 'install', 'log', 'node_modules', '__pycache__', 'site-packages'})
IGNORE_MARKS = frozenset({'COLCON_IGNORE', 'AMENT_IGNORE', 'pyvenv.cfg'})


class Workspace:
    """What one walk found."""

    __slots__ = ('complete', 'packages', 'remarks', 'root')

    def __init__(self, root: str) -> None:
        self.root = root
        self.packages: dict[str, str] = {}  # name -> folder; the nearest wins
        self.remarks: list[str] = []  # what a user who misses a package should know
        self.complete = True


def holds_definitions(folder: str) -> bool:
    """Whether a folder has definition files: msg/*.msg, srv/*.srv or action/*.action."""
    return any(True for kind in KINDS for _ in definition_names(folder, kind))


def definition_names(folder: str, kind: str) -> list[str]:
    """The type names that <folder>/<kind>/ defines, sorted; none where there is no such folder."""
    ending = '.' + kind
    try:
        files = os.listdir(os.path.join(folder, kind))
    except OSError:
        return []
    return sorted(name.removesuffix(ending) for name in files if name.endswith(ending) and name[0] != '.')


def scan(root: str) -> Workspace:
    """Walk the tree below root (root itself included)."""
    found = Workspace(root)
    level, visited = [root], 0
    for _ in range(LEVELS + 1):
        below: list[str] = []
        for folder in level:
            visited += 1
            if visited > FOLDERS:
                found.complete = False
                found.remarks.append(f'the search below {root} ended after {FOLDERS} folders')
                return found
            below += _visit(folder, found)
        level = below
    return found


def _visit(folder: str, found: Workspace) -> list[str]:
    """Note the package in this folder, or return the folders to look into next."""
    try:
        with os.scandir(folder) as entries:
            inside = {entry.name: entry for entry in entries}
    except OSError:
        return []
    if not IGNORE_MARKS.isdisjoint(inside):
        return []
    if 'package.xml' in inside:
        _note(folder, found)
        return []
    return [
        inside[name].path
        for name in sorted(inside)
        if name[0] != '.' and name not in IGNORED and _is_folder(inside[name])
    ]


def _is_folder(entry: 'os.DirEntry[str]') -> bool:
    try:
        return entry.is_dir()
    except OSError:  # a link that leads where we may not look
        return False


def _note(folder: str, found: Workspace) -> None:
    if not holds_definitions(folder):
        return
    name = _package_name(folder, found)
    if name is None:
        return
    if name in found.packages:
        found.remarks.append(
            f'{folder} is a second package named {name}; {found.packages[name]} is used '
            '(a file COLCON_IGNORE in a folder hides it)'
        )
        return
    found.packages[name] = folder


def _package_name(folder: str, found: Workspace) -> str | None:
    """The <name> of package.xml; None, with a remark, where the file cannot be read."""
    from xml.parsers import expat

    path: list[str] = []
    name: list[str] = []
    parser = expat.ParserCreate()
    parser.StartElementHandler = lambda tag, _: path.append(tag)
    parser.EndElementHandler = lambda _: path.pop()
    parser.CharacterDataHandler = lambda text: name.append(text) if path == ['package', 'name'] else None
    file = os.path.join(folder, 'package.xml')
    try:
        with open(file, 'rb') as content:
            parser.ParseFile(content)
    except OSError as error:
        found.remarks.append(f'{file} cannot be read: {error.strerror}')
    except expat.ExpatError as error:
        found.remarks.append(f'{file} is not well-formed XML: {error}')
    else:
        if text := ''.join(name).strip():
            return text
        found.remarks.append(f'{file} has no <name>')
    return None
