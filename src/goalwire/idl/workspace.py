"""Finds interface packages in a source tree, as colcon does: by their package.xml.

The walk goes level by level, at most LEVELS down and through at most FOLDERS folders and ENTRIES names, so
that an import in a home directory stays cheap. The folders may hold anything: a file that cannot be read is
noted for error messages, and never stops an import. A guarded walk skips folders that other users can
write to. Used by the import hook: nothing heavy is imported here.
"""

import os

from goalwire.files import LARGEST_DEFINITION, read_regular, show, why_others_write

TYPE_CHECKING = False  # importing typing would take 5 ms
if TYPE_CHECKING:
    from collections.abc import Iterator

MANIFEST = 'package.xml'
KINDS = ('msg', 'srv', 'action')
LEVELS = 4
FOLDERS = 1000
ENTRIES = 100_000
COMPARED = 100  # two packages with one name are compared if neither has more definitions
IGNORED = frozenset({'build', 'install', 'log', 'node_modules', '__pycache__', 'site-packages'})
IGNORE_MARKS = frozenset({'COLCON_IGNORE', 'AMENT_IGNORE', 'pyvenv.cfg'})


class Workspace:
    """The findings of one walk through a folder tree."""

    __slots__ = (
        'complete', 'entries', 'guarded', 'manifests', 'packages', 'refused', 'remarks', 'root', 'seen',
        'unnamed', 'unusable',
    )  # fmt: skip

    def __init__(self, root: str, *, guarded: bool = False) -> None:
        self.root = root
        self.guarded = guarded
        self.packages: dict[str, str] = {}  # interface packages, name -> folder; the nearest wins
        self.manifests: list[str] = []  # folders of all packages with a package.xml, the nearest first
        self.refused: list[str] = []  # remarks on folders that other users can write to
        self.remarks: list[str] = []  # notes for the error text on a missing package
        self.unusable: list[str] = []  # the remarks that name an unusable package.xml
        self.entries = 0  # number of directory entries read so far
        self.seen: set[tuple[int, int]] = set()  # device and inode of visited folders: links may form circles
        self.unnamed: list[str] = []  # folders with msg/, srv/ or action/ and no package.xml
        self.complete = True

    def remark(self, text: str, *, unusable: bool = False) -> None:
        """Keep a remark for an error text; `unusable`: it is on an unusable package.xml."""
        self.remarks.append(text)
        if unusable:
            self.unusable.append(text)


def holds_definitions(folder: str) -> bool:
    """Return whether a folder has definition files: msg/*.msg, srv/*.srv or action/*.action."""
    return any(True for kind in KINDS for _ in _definitions(folder, kind))


def definition_names(folder: str, kind: str) -> list[str]:
    """Return the sorted type names in <folder>/<kind>/; [] if there is no such folder."""
    return sorted(_definitions(folder, kind))


def _definitions(folder: str, kind: str) -> 'Iterator[str]':
    """Yield the type names in the order of the folder; only ENTRIES entries are read."""
    ending = '.' + kind
    try:
        with os.scandir(os.path.join(folder, kind)) as entries:
            for _, entry in zip(range(ENTRIES), entries, strict=False):
                name = entry.name.removesuffix(ending)
                if name != entry.name and name.isidentifier():  # other names cannot be imported
                    yield name
    except OSError:
        return


def scan(root: str, *, guarded: bool = False) -> Workspace:
    """Search the folder tree from `root` downwards, `root` included.

    If `guarded`, skip folders that other users can write to.
    """
    found = Workspace(root, guarded=guarded)
    level, visited = [root], 0
    for _ in range(LEVELS + 1):
        below: list[str] = []
        for folder in level:
            visited += 1
            if visited > FOLDERS or found.entries > ENTRIES:
                bound = f'{FOLDERS} folders' if visited > FOLDERS else f'{ENTRIES:,} files'
                found.complete = False
                found.remark(f'the search below {show(root)} ended after {bound}')
                return found
            below += _visit(folder, found)
        level = below
    return found


def _visit(folder: str, found: Workspace) -> list[str]:
    """Note the package in a folder, or return the folders inside to visit next."""
    inside: dict[str, os.DirEntry[str]] = {}
    try:
        state = os.stat(folder)
        if (state.st_dev, state.st_ino) in found.seen:
            return []
        found.seen.add((state.st_dev, state.st_ino))
        if found.guarded and _refuses(folder, state, found):
            return []
        with os.scandir(folder) as entries:
            for entry in entries:
                inside[entry.name] = entry
                found.entries += 1
                if found.entries > ENTRIES:
                    break
    except OSError:
        return []
    if not IGNORE_MARKS.isdisjoint(inside):
        return []
    if MANIFEST in inside:
        if not (found.guarded and _has_open_kind(inside, found)):
            found.manifests.append(folder)
            _note(folder, found)
        return []
    if not inside.keys().isdisjoint(KINDS):
        found.unnamed.append(folder)
    return [
        inside[name].path
        for name in sorted(inside)
        if name[0] != '.' and name not in IGNORED and _is_folder(inside[name])
    ]


def _refuses(folder: str, state: os.stat_result, found: Workspace) -> bool:
    """Return True, and note the folder as refused, if other users can write to it."""
    why = why_others_write(state)
    if why:
        found.refused.append(f'{show(folder)} is not searched, because {why}')
        found.remark(found.refused[-1])
    return bool(why)


def _has_open_kind(inside: 'dict[str, os.DirEntry[str]]', found: Workspace) -> bool:
    """Return True, and note the folder, if other users can write to a package's msg/, srv/ or action/."""
    there = [inside[kind] for kind in KINDS if kind in inside and _is_folder(inside[kind])]
    return any(_refuses(entry.path, os.stat(entry.path), found) for entry in there)


def _is_folder(entry: 'os.DirEntry[str]') -> bool:
    try:
        return entry.is_dir()
    except OSError:  # a link may lead to a place that cannot be read
        return False


def _note(folder: str, found: Workspace) -> None:
    if not holds_definitions(folder):
        return
    try:
        name = package_name(os.path.join(folder, MANIFEST))
    except ValueError as error:
        found.remark(str(error), unusable=True)
        return
    if name in found.packages:
        if _is_copy(folder, found.packages[name]):
            return  # both folders give the same classes
        found.remark(
            f'{show(folder)} is a second package named {name}; {show(found.packages[name])} is used '
            '(a file COLCON_IGNORE in a folder hides it)'
        )
        return
    found.packages[name] = folder


def _is_copy(one: str, other: str) -> bool:
    """Return whether two folders have the same few definitions, as the exercises of the course do."""
    names = [(kind, name) for kind in KINDS for name in definition_names(one, kind)]
    if names != [(kind, name) for kind in KINDS for name in definition_names(other, kind)]:
        return False
    try:
        return len(names) <= COMPARED and all(
            read_regular(os.path.join(one, *path), LARGEST_DEFINITION)
            == read_regular(os.path.join(other, *path), LARGEST_DEFINITION)
            for path in ((kind, f'{name}.{kind}') for kind, name in names)
        )
    except OSError:
        return False


def package_name(manifest: str) -> str:
    """Return the <name> in a package.xml; raises ValueError that names the file and the fault."""
    from goalwire import xml_tree

    file = show(manifest)
    try:
        root = xml_tree.read(read_regular(manifest, LARGEST_DEFINITION))
    except OSError as error:
        raise ValueError(f'{file} cannot be read: {error.strerror}') from None
    except xml_tree.XmlError as error:
        raise ValueError(f'{file} is not well-formed XML: {error}') from None
    names = root.findall('name') if root.tag == 'package' else []
    text = ''.join(element.text for element in names).strip()
    if not text:
        raise ValueError(f'{file} has no <name>')
    if not is_package_name(text):
        raise ValueError(
            f'{file} has the <name> {show(text, 60)!r}: a name has lower-case letters, digits and single '
            'underscores, with a letter first'
        )
    return text


def explain_unnamed(folder: str, package: str) -> str | None:
    """Return the error text for a folder that has definitions but no package.xml; None for other folders."""
    if os.path.lexists(os.path.join(folder, MANIFEST)) or not holds_definitions(folder):
        return None
    place = show(os.path.join(folder, MANIFEST))
    return (
        f'{show(folder)} holds definitions, but no {MANIFEST} says what package they are: '
        f'write {place}, at least <package format="3"><name>{package}</name></package>'
    )


def is_package_name(name: str) -> bool:
    """Return True for a name by ROS 2's rule (REP 144): lower case, digits, single _, a letter first."""
    plain = name.isascii() and name.isidentifier() and name == name.lower()
    return plain and name[0] != '_' and name[-1] != '_' and '__' not in name
