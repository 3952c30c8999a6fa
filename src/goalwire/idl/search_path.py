"""Where an interface package's definition files are, in this order:

1. GOALWIRE_INTERFACE_PATH   folders, separated as in PATH: each a package, or a folder of packages
2. AMENT_PREFIX_PATH         <prefix>/share/<package>/
3. entry points              group goalwire.interfaces, see entry_points.py
4. the Python package        msg/, srv/, action/ in the Python package of that name, or beside it
5. the working directory     package.xml at most four levels down, see workspace.py
6. the program's folder      the same, below the folder of the script that runs
7. the shipped packages      share/ beside this file

Importable rosidl packages come before all of these: that is the import hook's business. Used by the
import hook, so nothing heavy is imported at the top.
"""

import os
import sys

from goalwire.errors import UnknownInterfaceError
from goalwire.files import shown
from goalwire.idl import entry_points, workspace
from goalwire.idl.workspace import KINDS

TYPE_CHECKING = False  # typing would cost 5 ms
if TYPE_CHECKING:
    from pathlib import Path

SHIPPED = os.path.join(os.path.dirname(__file__), 'share')
INTERFACE_PATH = 'GOALWIRE_INTERFACE_PATH'
PREFIX_PATH = 'AMENT_PREFIX_PATH'
_NOTES = 5  # folders without package.xml that a message names
INSTALLED = frozenset({'site-packages', 'dist-packages'})


class InterfacePackage:
    """A package's name and the folder that holds msg/, srv/ and action/."""

    __slots__ = ('folder', 'name', 'origin')

    def __init__(self, name: str, folder: str, origin: str) -> None:
        self.name = name
        self.folder = folder
        self.origin = origin  # which step of the search found it, for messages

    def __repr__(self) -> str:
        return f'InterfacePackage({self.name!r}, {self.folder!r}, from {self.origin})'

    @property
    def path(self) -> 'Path':
        from pathlib import Path

        return Path(self.folder)

    def files(self) -> 'dict[str, Path]':
        """Definition files by 'msg/Name', 'srv/Name', 'action/Name', sorted; read anew at each call."""
        return {
            f'{kind}/{name}': self.path / kind / f'{name}.{kind}'
            for kind in KINDS
            for name in workspace.definition_names(self.folder, kind)
        }


_Key = tuple[str, str | None, str | None, tuple[tuple[str, str], ...], tuple[str, ...]]
_found: dict[_Key, InterfacePackage | None] = {}
_workspaces: dict[str, workspace.Workspace] = {}
_warned: set[str] = set()


def find_package(package: str) -> InterfacePackage | None:
    """Find a package's definition files; None where there are none.

    Answers are kept until an environment variable, the working directory, the program or sys.path changes,
    or importlib.invalidate_caches() is called. Raises UnknownInterfaceError for a name that no package has.
    """
    if not workspace.is_package_name(package):
        raise UnknownInterfaceError(
            f'{package!r} is no ROS package name: use lower-case letters, digits and single underscores, '
            'with a letter first'
        )
    variables = os.environ.get(INTERFACE_PATH), os.environ.get(PREFIX_PATH)
    key = (package, *variables, _roots(), entry_points.python_path())
    if key not in _found:
        _found[key] = _search(package)
    return _found[key]


def imported_package(package: str, kind: str) -> InterfacePackage | None:
    """Return where the package that was imported is, else what `find_package` finds; raises as that does.

    As with Python's own packages, one that is imported stays where it was found.
    """
    for name in (package, f'{package}.{kind}'):  # the hook serves a Python package's msg alone
        found = getattr(getattr(sys.modules.get(name), '__spec__', None), 'loader_state', None)
        if isinstance(found, InterfacePackage):
            return found
    return find_package(package)


def package_names() -> list[str]:
    """The names of all packages that find_package finds, sorted; for tools, not for imports."""
    names = set(_listing(SHIPPED)) | set(entry_points.registrations())
    for entry in _entries(INTERFACE_PATH):
        names |= {os.path.basename(entry.rstrip(os.sep))} | set(_listing(entry))
    for prefix in _entries(PREFIX_PATH):
        names |= set(_listing(os.path.join(prefix, 'share')))
    for _, here in _workspace_walks():
        names |= set(here.packages)
    return sorted(name for name in names if workspace.is_package_name(name) and find_package(name))


def explain_missing(package: str) -> str:
    """Return the error text for a missing package: the places searched, similar names, what to do."""
    from difflib import get_close_matches

    lines = [f'no interface package named {package!r}. Looked in:']
    lines += [f'  {name}: {_describe_variable(name)}' for name in (INTERFACE_PATH, PREFIX_PATH)]
    names = ', '.join(sorted(entry_points.registrations())) or 'none registered'
    lines.append(f'  entry points {entry_points.GROUP}: {names}')
    for place, here in _workspace_walks():
        found = ', '.join(sorted(here.packages)) or 'no interface package'
        lines.append(f'  below {place} {shown(here.root)}: {found}')
        lines += [f'    note: {remark}' for remark in here.remarks]
        unnamed = (workspace.explain_unnamed(folder, _name_for(folder, package)) for folder in here.unnamed)
        lines += [
            f'    note: {remark}' for remark, _ in zip(filter(None, unnamed), range(_NOTES), strict=False)
        ]
    lines.append('  the packages that goalwire ships')
    if close := get_close_matches(package, package_names(), n=3):
        lines.append(f'Did you mean {" or ".join(close)}?')
    lines.append(f'Start the program in its workspace, or name the folder of {package} in {INTERFACE_PATH}.')
    return '\n'.join(lines)


def _name_for(folder: str, package: str) -> str:
    """The name to give to a package in this folder: its own, or the one that was asked for."""
    name = os.path.basename(folder)
    return name if workspace.is_package_name(name) else package


def discard() -> None:
    """Discard what was found: search afresh from now on (importlib.invalidate_caches() does this)."""
    _found.clear()
    _workspaces.clear()
    entry_points.discard()


def _search(package: str) -> InterfacePackage | None:
    for entry in _entries(INTERFACE_PATH):
        for folder in (os.path.join(entry, package), entry):
            if os.path.basename(folder.rstrip(os.sep)) == package and workspace.holds_definitions(folder):
                return InterfacePackage(package, folder, INTERFACE_PATH)
    for prefix in _entries(PREFIX_PATH):
        folder = os.path.join(prefix, 'share', package)
        if workspace.holds_definitions(folder):
            return InterfacePackage(package, folder, PREFIX_PATH)
    return (
        _search_registered(package)
        or _search_python(package)
        or _search_workspaces(package)
        or _search_shipped(package)
    )


def _search_registered(package: str) -> InterfacePackage | None:
    value = entry_points.registrations().get(package)
    if value is None:
        return None
    folder = entry_points.folder_of(value)
    if folder is None or not workspace.holds_definitions(folder):
        _warn(
            f'entry point {entry_points.GROUP}: {package} = {value} leads to no folder with msg/, srv/ or '
            'action/; it is passed over'
        )
        return None
    return InterfacePackage(package, folder, f'the entry point {entry_points.GROUP}')


def _search_python(package: str) -> InterfacePackage | None:
    """Interfaces of a Python package: installed in it, or in the source folder of an editable install."""
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
            _warn(str(error))
    return None


def _search_workspaces(package: str) -> InterfacePackage | None:
    for place, here in _workspace_walks():
        if package in here.packages:
            for remark in here.remarks:
                if f'second package named {package};' in remark:
                    _warn(remark)
            return InterfacePackage(package, here.packages[package], place)
    return None


def _search_shipped(package: str) -> InterfacePackage | None:
    folder = os.path.join(SHIPPED, package)
    return InterfacePackage(package, folder, 'goalwire') if workspace.holds_definitions(folder) else None


def _entries(variable: str) -> list[str]:
    entries = [entry for entry in os.environ.get(variable, '').split(os.pathsep) if entry]
    try:
        return [os.path.abspath(entry) for entry in entries]
    except OSError:  # the working directory was removed: nothing is relative to it
        return [entry for entry in entries if os.path.isabs(entry)]


def _describe_variable(variable: str) -> str:
    entries = [entry if os.path.isdir(entry) else f'{entry} (no such folder)' for entry in _entries(variable)]
    return ', '.join(map(shown, entries)) or 'not set'


def _listing(folder: str) -> list[str]:
    try:
        return os.listdir(folder)
    except OSError:
        return []


def _roots() -> tuple[tuple[str, str], ...]:
    """Where workspaces are looked for: what to call the place, and its folder."""
    roots = {}
    try:
        roots[os.getcwd()] = 'the working directory'
    except OSError:  # it was removed
        roots = {}
    if folder := _program_folder():
        roots.setdefault(folder, "the program's folder")
    return tuple((place, root) for root, place in roots.items())


def _program_folder() -> str | None:
    """The folder of the script that Python was started with; None where there is none, or it is installed."""
    for name in ('__mp_main__', '__main__'):  # a process that multiprocessing spawned has the first
        file = getattr(sys.modules.get(name), '__file__', None)
        if isinstance(file, str) and os.path.isabs(file):
            folder = os.path.dirname(os.path.normpath(file))
            installed = folder == os.path.dirname(sys.executable) or INSTALLED & set(folder.split(os.sep))
            return None if installed else folder
    return None


def _workspace_walks() -> list[tuple[str, workspace.Workspace]]:
    """Walk below the roots, each once; what cannot be used there is warned of once."""
    walks = []
    for place, root in _roots():
        if root not in _workspaces:
            found = _workspaces[root] = workspace.scan(root)
            for remark in found.unusable:
                _warn(remark)
        walks.append((place, _workspaces[root]))
    return walks


def _warn(text: str) -> None:
    """Warn of a text once: a search that starts afresh finds the same again."""
    if text in _warned:
        return
    _warned.add(text)
    import warnings

    warnings.warn(text, RuntimeWarning, stacklevel=2)
