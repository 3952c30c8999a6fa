"""Where an interface package's definition files are, in this order:

1. GOALWIRE_INTERFACE_PATH   folders, separated as in PATH: each a package, or a folder of packages
2. AMENT_PREFIX_PATH         <prefix>/share/<package>/
3. entry points              group goalwire.interfaces, see entry_points.py
4. the Python package        msg/, srv/, action/ in the Python package of that name, or beside it
5. the shipped packages      share/ beside this file
6. the working directory     package.xml at most four levels down, see workspace.py and workspace_roots.py
7. the program's folder      the same, below the folder of the script that runs

Only a folder that is named (1 to 4) overrides a shipped package: otherwise any folder below the working
directory could break every program. Importable rosidl packages come before all of these, since the import
hook asks Python's own finders first. The hook imports this module, so nothing heavy is imported at the top.
"""

import os
import sys

from goalwire.errors import UnknownInterfaceError
from goalwire.files import show
from goalwire.idl import entry_points, workspace, workspace_roots
from goalwire.idl.workspace import KINDS

TYPE_CHECKING = False  # importing typing would take 5 ms
if TYPE_CHECKING:
    from pathlib import Path

SHIPPED = os.path.join(os.path.dirname(__file__), 'share')
SHIPPED_ORIGIN = 'goalwire'
INTERFACE_PATH = 'GOALWIRE_INTERFACE_PATH'
PREFIX_PATH = 'AMENT_PREFIX_PATH'
_COMMON_ENDINGS = '_(msgs?|srvs?|interfaces?)$'
_NOTES = 5  # an error text names so many folders at most for each reason


class InterfacePackage:
    """A package's name and the folder that holds msg/, srv/ and action/."""

    __slots__ = ('folder', 'name', 'origin', 'trusted')

    def __init__(self, name: str, folder: str, origin: str, *, trusted: bool = True) -> None:
        self.name = name
        self.folder = folder
        self.origin = origin  # the step of the search that found the package, for messages
        self.trusted = trusted  # if False, the use of this package is reported

    def __repr__(self) -> str:
        return f'InterfacePackage({self.name!r}, {self.folder!r}, from {self.origin})'

    @property
    def path(self) -> 'Path':
        from pathlib import Path

        return Path(self.folder)

    def tell_use(self) -> None:
        """Report once where the package was found, if that is below an untrusted working directory."""
        if not self.trusted:
            workspace_roots.tell_origin(self.name, self.folder)

    def files(self) -> 'dict[str, Path]':
        """Return the definition files by 'msg/Name', 'srv/Name', 'action/Name', sorted and listed anew."""
        return {
            f'{kind}/{name}': self.path / kind / f'{name}.{kind}'
            for kind in KINDS
            for name in workspace.definition_names(self.folder, kind)
        }


_Key = tuple[str, str | None, str | None, tuple[tuple[str, bool], ...], tuple[str, ...]]
_found: dict[_Key, InterfacePackage | None] = {}


def find_package(package: str, *, walk: bool = True) -> InterfacePackage | None:
    """Find the folder of a package's definition files; return None if there is none.

    Without `walk`, packages below the working directory must have been found by an earlier walk. Answers are
    kept until an environment variable, the working directory, the program or sys.path changes, or
    importlib.invalidate_caches() is called. Raises UnknownInterfaceError for a name that no package may have.
    """
    if not workspace.is_package_name(package):
        raise UnknownInterfaceError(
            f'{package!r} is no ROS package name: use lower-case letters, digits and single underscores, '
            'with a letter first'
        )
    variables = os.environ.get(INTERFACE_PATH), os.environ.get(PREFIX_PATH)
    roots = tuple((root.folder, root.trusted) for root in workspace_roots.find_roots())
    key = (package, *variables, roots, entry_points.python_path())
    if key in _found:
        return _found[key]
    found = _search(package, walk=walk)
    if found or walk:
        _found[key] = found
    return found


def find_imported_package(package: str, kind: str) -> InterfacePackage | None:
    """Return an imported package as it was found, otherwise the result of `find_package`, which may raise.

    As with Python's own packages, an imported package stays in the folder where it was found.
    """
    for name in (package, f'{package}.{kind}'):  # either may be imported by the hook
        found = getattr(getattr(sys.modules.get(name), '__spec__', None), 'loader_state', None)
        if isinstance(found, InterfacePackage):
            return found
    return find_package(package)


def package_names() -> list[str]:
    """Return the sorted names of all packages that find_package finds; for tools, too slow for imports."""
    names = set(_listing(SHIPPED)) | set(entry_points.registrations())
    for entry in _entries(INTERFACE_PATH):
        names |= _names_of(entry) | set(_listing(entry))
    for prefix in _entries(PREFIX_PATH):
        names |= set(_listing(os.path.join(prefix, 'share')))
    for root in workspace_roots.find_roots():
        names |= set(workspace_roots.walk(root).packages)
    return sorted(name for name in names if workspace.is_package_name(name) and find_package(name))


def explain_missing(package: str) -> str:
    """Return the error text for a missing package: the searched places, similar names, and advice."""
    lines = ['Looked in:']
    lines += [f'  {name}: {_describe_variable(name)}' for name in (INTERFACE_PATH, PREFIX_PATH)]
    names = ', '.join(sorted(entry_points.registrations())) or 'none registered'
    lines.append(f'  entry points {entry_points.GROUP}: {names}')
    lines.append('  the packages that goalwire ships')
    near: list[str] = []
    for root in workspace_roots.find_roots():
        here = workspace_roots.walk(root)
        found = ', '.join(sorted(here.packages)) or 'no interface package'
        lines.append(f'  below {root.place} {show(here.root)}: {found}')
        lines += [f'    note: {remark}' for remark in _shorten(here)]
        near += [f'    note: {remark}' for remark in _explain_near(here, package)]
        unnamed = (workspace.explain_unnamed(folder, _name_for(folder, package)) for folder in here.unnamed)
        lines += [
            f'    note: {remark}' for remark, _ in zip(filter(None, unnamed), range(_NOTES), strict=False)
        ]
    missing = f'no interface package named {package!r}. '
    if near:  # a folder of that name exists, but has a fault
        return '\n'.join([f'{missing}{lines[0]}', *lines[1:], *near])
    close = _similar_names(package)
    guess = f'Did you mean {" or ".join(close)}? ' if close else ''
    advice = (
        f'If {package} is your own package, start the program in its workspace, or name its folder in '
        f'{INTERFACE_PATH}. If others made it, copy its folder, with package.xml, into your workspace.'
    )
    return '\n'.join([f'{missing}{guess}{advice}', *lines])


def _similar_names(package: str) -> list[str]:
    """Return the names of packages with similar names; common endings such as _msgs are not compared."""
    import re
    from difflib import get_close_matches

    names: dict[str, list[str]] = {}
    for name in package_names():
        names.setdefault(re.sub(_COMMON_ENDINGS, '', name), []).append(name)
    stems = get_close_matches(re.sub(_COMMON_ENDINGS, '', package), names, n=3)
    return [name for stem in stems for name in names[stem]][:3]


def _explain_near(here: workspace.Workspace, package: str) -> list[str]:
    """Return why a folder named like the package is not it: another <name>, or files in wrong places."""
    remarks = []
    for folder in here.manifests:
        if os.path.basename(folder) != package:
            continue
        manifest = show(os.path.join(folder, 'package.xml'))
        remarks += [
            f'{manifest} names the package {name}: write <name>{package}</name>'
            for name, place in here.packages.items()
            if place == folder
        ]
        for file in sorted(os.listdir(folder)):
            kind = file.rpartition('.')[2]
            if kind in workspace.KINDS and kind != file:  # not the folder srv itself
                inside = show(os.path.join(folder, kind, file))
                remarks.append(f'{file} lies beside {manifest}: move it to {inside}')
    return remarks[:_NOTES]


def _name_for(folder: str, package: str) -> str:
    """Return a name for the package in a folder: the folder's name if valid, else the requested one."""
    name = os.path.basename(folder)
    return name if workspace.is_package_name(name) else package


def explain_overridden(package: str) -> str:
    """Return a text on another folder of a shipped package, which is unused unless named; '' for none."""
    found = find_package(package)
    if found is None or found.origin != SHIPPED_ORIGIN:
        return ''
    for root in workspace_roots.find_roots():
        folder = workspace_roots.walk(root).packages.get(package)
        if folder:
            return (
                f'goalwire ships this {package}, and {show(folder)} is another: '
                f'to use that one, name it in {INTERFACE_PATH}'
            )
    return ''


def explain_refused() -> str:
    """Return a text, with advice, on folders not searched since others can write to them; '' for none."""
    refused = [text for root in workspace_roots.find_roots() for text in workspace_roots.walk(root).refused]
    if not refused:
        return ''
    others = f' (and {len(refused) - 1} more)' if len(refused) > 1 else ''
    return f'{refused[0]}{others}: name a package there in {INTERFACE_PATH}'


def _shorten(here: workspace.Workspace) -> list[str]:
    """Return the remarks of a walk, but only a few of those on folders that other users can write to."""
    more = here.refused[_NOTES:]
    remarks = [remark for remark in here.remarks if remark not in more]
    return [*remarks, f'{len(more)} more folders are not searched for that reason'] if more else remarks


def discard() -> None:
    """Forget all findings, so that the next call searches anew; importlib.invalidate_caches() calls this."""
    _found.clear()
    workspace_roots.discard()
    entry_points.discard()


def _search(package: str, *, walk: bool) -> InterfacePackage | None:
    for entry in _entries(INTERFACE_PATH):
        for folder in (os.path.join(entry, package), entry):
            if workspace.holds_definitions(folder) and package in _names_of(folder):
                return InterfacePackage(package, folder, INTERFACE_PATH)
    for prefix in _entries(PREFIX_PATH):
        folder = os.path.join(prefix, 'share', package)
        if workspace.holds_definitions(folder):
            return InterfacePackage(package, folder, PREFIX_PATH)
    return (
        _search_registered(package)
        or _search_python(package)
        or _search_shipped(package)
        or _search_workspaces(package, walk=walk)
    )


def _names_of(folder: str) -> set[str]:
    """Return the package names of a folder with definitions: its own name, and that in its package.xml."""
    names = {os.path.basename(folder.rstrip(os.sep))}
    manifest = os.path.join(folder, workspace.MANIFEST)
    if os.path.isfile(manifest):
        try:
            names.add(workspace.package_name(manifest))
        except ValueError as error:
            workspace_roots.warn_once(str(error))
    return names


def _search_registered(package: str) -> InterfacePackage | None:
    value = entry_points.registrations().get(package)
    if value is None:
        return None
    folder = entry_points.folder_of(value)
    if folder is None or not workspace.holds_definitions(folder):
        workspace_roots.warn_once(
            f'entry point {entry_points.GROUP}: {package} = {value} leads to no folder with msg/, srv/ or '
            'action/; it is passed over'
        )
        return None
    return InterfacePackage(package, folder, f'the entry point {entry_points.GROUP}')


def _search_python(package: str) -> InterfacePackage | None:
    """Find interfaces in a Python package, or in the source folder of an editable install."""
    folder = entry_points.folder_of(package, regular=True)
    if folder is None:
        return None
    source = os.path.dirname(folder)
    manifest = os.path.join(source, workspace.MANIFEST)
    if workspace.holds_definitions(folder):
        return InterfacePackage(package, folder, 'the Python package')
    if os.path.isfile(manifest) and workspace.holds_definitions(source):
        try:
            if workspace.package_name(manifest) == package:
                return InterfacePackage(package, source, 'the Python package')
        except ValueError as error:
            workspace_roots.warn_once(str(error))
    return None


def _search_workspaces(package: str, *, walk: bool) -> InterfacePackage | None:
    for root in workspace_roots.find_roots():
        here = workspace_roots.walk(root) if walk else workspace_roots.recall_walk(root)
        if here is not None and package in here.packages:
            for remark in here.remarks:
                if f'second package named {package};' in remark:
                    workspace_roots.warn_once(remark)
            return InterfacePackage(package, here.packages[package], root.place, trusted=root.trusted)
    return None


def _search_shipped(package: str) -> InterfacePackage | None:
    folder = os.path.join(SHIPPED, package)
    return InterfacePackage(package, folder, SHIPPED_ORIGIN) if workspace.holds_definitions(folder) else None


def _entries(variable: str) -> list[str]:
    entries = [entry for entry in os.environ.get(variable, '').split(os.pathsep) if entry]
    try:
        return [os.path.abspath(entry) for entry in entries]
    except OSError:  # the working directory was removed, so relative entries lead nowhere
        return [entry for entry in entries if os.path.isabs(entry)]


def _describe_variable(variable: str) -> str:
    entries = [entry if os.path.isdir(entry) else f'{entry} (no such folder)' for entry in _entries(variable)]
    return ', '.join(map(show, entries)) or 'not set'


def _listing(folder: str) -> list[str]:
    try:
        return os.listdir(folder)
    except OSError:
        return []
