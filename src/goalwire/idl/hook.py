"""The import hook: serves interface packages from their definition files, and gives the overlay its rank.

The first import that is not of Python's own library loads this module (overlay/_goalwire_start.py), so the
module imports only what Python has loaded by then. The finder stands just before Python's path finder, asks
the path finder and all finders behind it first, and then decides:

- A regular package or module always wins. A folder without __init__.py, which Python would take for a
  namespace package, does not win: ./humanoid_interfaces/ may be a source folder.
- Modules in goalwire/overlay/ (rclpy and its companions) come last, wherever the overlay stands in sys.path;
  with GOALWIRE_FIRST=1, which `python -m goalwire.run` sets, they come first.
- A Python package and an interface package may share a name: then the hook serves only msg, srv and action.
- Beside a real rclpy the hook serves nothing, because that ROS 2 has its own interface packages.

Every Python program loads this module, even pip, and the searched folders may contain anything. So a failure
while packages are searched becomes a warning, and the name counts as not found.
"""

import _imp
import os
import sys
from _frozen_importlib_external import FileFinder, PathFinder  # importlib.machinery would take 0.3 ms

TYPE_CHECKING = False  # importing typing would take 5 ms
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from importlib.machinery import ModuleSpec
    from types import FrameType, ModuleType

    from goalwire.idl.search_path import InterfacePackage

OVERLAY = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'overlay')
OVERLAY_FIRST = 'GOALWIRE_FIRST'
# Python itself tries to import these names, and expects that they may be missing.
NEVER_PACKAGES = sys.stdlib_module_names | {
    'sitecustomize',
    'usercustomize',
    'apport_python_hook',  # Debian's and Ubuntu's Python imports it at each start
    'org',
    'java',
}
KINDS = ('msg', 'srv', 'action')
# The source files of the stack frames between an import statement and this module's finder.
_IMPORTERS = frozenset(
    {
        __file__,
        PathFinder.find_spec.__code__.co_filename,
        PathFinder.find_spec.__code__.co_filename.replace('_external', ''),
        os.path.join(os.path.dirname(os.__file__), 'importlib', '__init__.py'),
    }
)
TELLING_ENDINGS = ('_msgs', '_srvs', '_interfaces', '_actions', '_interface')


class InterfaceFinder:
    """A meta path finder for std_msgs, humanoid_interfaces and the like."""

    finds_interfaces = True  # by this attribute `entry_points.py` recognises the hook among the finders

    def __init__(self) -> None:
        self._served: set[str] = set()  # interface packages, and 'name.msg' and so on in Python packages

    def find_spec(
        self, fullname: str, path: 'Sequence[str] | None' = None, target: 'ModuleType | None' = None
    ) -> 'ModuleSpec | None':
        """Find a module as importlib asks for it.

        Raises ImportError for a type that a served package lacks, and ModuleNotFoundError, with the places
        that were searched, for an import statement that names a missing package like foo_msgs. Raises nothing
        else.
        """
        if path is not None:
            package, _, rest = fullname.partition('.')
            if package in self._served or fullname.rpartition('.')[0] in self._served:
                return _search_carefully(lambda name: self._inner_spec(name, path), fullname)
            if rest not in KINDS or _is_regular(self._ask_behind(fullname, target, path)):
                return None
            return _search_carefully(lambda name: self._kind_spec(name, path), fullname)
        found = self._module_spec(fullname, target)
        if found is not None and found.loader is not None:
            if found.origin is not None and os.path.basename(found.origin) == f'{fullname}.py':
                _tell_hidden(fullname, found.origin)
            return found
        return _search_carefully(lambda name: self._package_spec(name, found), fullname) or found

    def invalidate_caches(self) -> None:
        """Search for packages afresh from now on; importlib.invalidate_caches() calls this method."""
        if search_path := sys.modules.get('goalwire.idl.search_path'):
            search_path.discard()

    def _module_spec(self, fullname: str, target: 'ModuleType | None') -> 'ModuleSpec | None':
        """Find a regular module or package (the overlay's if no other exists), else a namespace folder."""
        if os.environ.get(OVERLAY_FIRST) == '1' and (spec := _regular(fullname, [OVERLAY])):
            return spec
        found = self._ask_behind(fullname, target)
        if found is not None and found.loader is not None:
            return _not_ours(fullname, found) or found
        return _regular(fullname, [OVERLAY]) or found

    def _ask_behind(
        self, fullname: str, target: 'ModuleType | None', path: 'Sequence[str] | None' = None
    ) -> 'ModuleSpec | None':
        """Ask the finders behind this finder, for a module or else for a namespace folder."""
        namespace = None
        for finder in _behind(self):
            spec = finder.find_spec(fullname, path, target)
            if spec is not None and spec.loader is not None:
                return spec
            namespace = namespace or spec
        return namespace

    def _package_spec(self, name: str, namespace: 'ModuleSpec | None') -> 'ModuleSpec | None':
        if name in NEVER_PACKAGES or name[0] == '_':
            return None
        from goalwire.idl import search_path, workspace

        if not workspace.is_package_name(name) or self._real_rclpy():
            return None
        found = search_path.find_package(name, walk=_wants_interfaces(name))
        if found and (beside := _python_beside(found, namespace)):
            return beside
        if found or _is_registered(name):
            from goalwire.idl import modules

            self._served.add(name)
            return modules.package_spec(name, found, _stubs_of(found) if found else '')
        if name.endswith(TELLING_ENDINGS) and _asked_by_import_statement():
            text = f'No module named {name!r}, and {search_path.explain_missing(name)}'
            raise ModuleNotFoundError(text, name=name)
        return None

    def _kind_spec(self, fullname: str, path: 'Sequence[str]') -> 'ModuleSpec | None':
        """Return the import spec of the submodule msg, srv or action of the Python package at `path`."""
        package = fullname.partition('.')[0]
        if package in NEVER_PACKAGES or package[0] == '_':
            return None
        from goalwire.idl import search_path, workspace

        if not workspace.is_package_name(package) or self._real_rclpy():
            return None
        found = search_path.find_package(package)
        if not (found or _is_registered(package)):
            if _asked_by_import_statement():
                _refuse_unnamed(fullname, path)
            return None
        from goalwire.idl import modules

        spec = modules.inner_spec(fullname, path, found)
        if spec is not None:
            self._served.add(fullname)
        return spec

    def _inner_spec(self, fullname: str, path: 'Sequence[str]') -> 'ModuleSpec | None':
        from goalwire.idl import modules

        spec = modules.inner_spec(fullname, path)
        if spec is None and _asked_by_import_statement() and (text := modules.explain_unknown(fullname)):
            # A from-import suppresses a ModuleNotFoundError, and so its text, but not an ImportError.
            of_a_type = fullname.count('.') > 1 or fullname.rpartition('.')[2][0].isupper()
            raise (ImportError if of_a_type else ModuleNotFoundError)(text, name=fullname)
        return spec

    def _real_rclpy(self) -> bool:
        """Return True if `import rclpy` finds an rclpy that is not goalwire's."""
        loaded = sys.modules.get('rclpy')
        spec = loaded.__spec__ if loaded is not None else self._module_spec('rclpy', None)
        return spec is not None and spec.origin is not None and not _is_ours(spec)


class OverlayFinder(FileFinder):
    """Finds the overlay's modules, but no namespace packages: folders without __init__.py only hold stubs."""

    def find_spec(self, fullname: str, target: 'ModuleType | None' = None) -> 'ModuleSpec | None':
        spec = super().find_spec(fullname, target)
        return None if spec is None or spec.loader is None else spec


def install() -> None:
    """Put goalwire's finder before Python's path finder, once; overlay/_goalwire_start.py calls this.

    Raises ImportError if goalwire lies in a zip file, where definitions cannot be read.
    """
    if not (os.path.isdir(os.path.dirname(OVERLAY)) or getattr(sys, 'frozen', False)):
        raise ImportError(
            f'goalwire lies in the zip file {_zip_file()}, where its definitions and modules cannot be '
            'read: take shiv or pex, which unpack themselves'
        )
    _imp.acquire_lock()  # two threads may get here at once by their first imports
    try:
        if any(isinstance(finder, InterfaceFinder) for finder in sys.meta_path):
            return
        if finder := _overlay_finder():
            sys.path_importer_cache[OVERLAY] = finder
        place = sys.meta_path.index(PathFinder) if PathFinder in sys.meta_path else len(sys.meta_path)
        sys.meta_path.insert(place, InterfaceFinder())
    finally:
        _imp.release_lock()


def _zip_file() -> str:
    """Return the zip file that contains goalwire, if it is not unpacked."""
    place = OVERLAY
    while not os.path.exists(place) and place != os.path.dirname(place):
        place = os.path.dirname(place)
    return place


def _search_carefully(search: 'Callable[[str], ModuleSpec | None]', name: str) -> 'ModuleSpec | None':
    """Return the result of a search. An error other than ImportError becomes a warning; then return None."""
    try:
        return search(name)
    except ImportError:
        _hide_own_frames()
        raise
    except Warning as warning:  # warnings are errors in this program; an import may raise ImportError alone
        if _asked_by_import_statement():
            raise ImportError(str(warning), name=name) from None
    except Exception as error:
        import warnings

        text = f'goalwire cannot look for interfaces of {name!r}: {type(error).__name__}: {error}'
        try:
            warnings.warn(text, RuntimeWarning, stacklevel=2)
        except Warning:
            raise ImportError(text, name=name) from error
    return None


def _tell_hidden(name: str, file: str) -> None:
    """Warn that a program's own file has the name of a package, and so hides the package from imports."""
    shipped = os.path.join(os.path.dirname(OVERLAY), 'idl', 'share', name)
    if name == 'rclpy' or os.path.isdir(shipped):
        sys.stderr.write(f"goalwire: {file} hides the package '{name}': give this file another name\n")


def _hide_own_frames() -> None:
    """Make an uncaught error show a traceback with only the program's own lines."""
    from goalwire.tracebacks import hide_own_frames

    hide_own_frames()


def _overlay_finder() -> 'FileFinder | None':
    for make in sys.path_hooks:
        try:
            finder = make(OVERLAY)
        except ImportError:  # this path hook does not handle folders
            continue
        if isinstance(finder, FileFinder):
            # The finder knows the suffixes of modules, which have no public name
            finder.__class__ = OverlayFinder
            return finder
    return None


def _stubs_of(found: 'InterfacePackage') -> str:
    """Return the folder of a package's type stubs: in the overlay, or for other packages in the cache."""
    from goalwire.idl import search_path

    if found.origin == search_path.SHIPPED_ORIGIN:
        return os.path.join(OVERLAY, found.name)
    from goalwire.idl import editor_stubs

    return editor_stubs.prepare(found)


def _python_beside(found: 'InterfacePackage', namespace: 'ModuleSpec | None') -> 'ModuleSpec | None':
    """Find the Python package in a source folder beside the interfaces: my_robot/my_robot/__init__.py.

    Return it only if Python's own search, or GOALWIRE_INTERFACE_PATH, leads to that folder: other code below
    the working directory may come from a stranger, and is not run.
    """
    from goalwire.idl.search_path import INTERFACE_PATH

    places = getattr(namespace, 'submodule_search_locations', None) or ()
    if found.origin == INTERFACE_PATH or found.folder in (os.path.abspath(place) for place in places):
        return _regular(found.name, [found.folder])
    return None


def _refuse_unnamed(fullname: str, path: 'Sequence[str]') -> None:
    """Raise ModuleNotFoundError if name.msg is a folder of definitions whose package.xml is missing."""
    from goalwire.idl import workspace

    package, _, kind = fullname.partition('.')
    for folder in map(os.path.abspath, path):
        inside = os.path.join(folder, kind)
        modules = os.path.isdir(inside) and any(name.endswith('.py') for name in os.listdir(inside))
        if not modules and (text := workspace.explain_unnamed(folder, package)):
            raise ModuleNotFoundError(f'No module named {fullname!r}: {text}', name=fullname)


def _is_registered(package: str) -> bool:
    """Return True if register_definitions() has registered types for this package."""
    # If another thread is still importing the registry, nothing is registered yet.
    types = getattr(sys.modules.get('goalwire.idl.registry'), 'registered_types', None)
    return types is not None and bool(types(package))


def _behind(finder: InterfaceFinder) -> 'Iterator[type[PathFinder]]':
    """Yield the finders after the given one that have a find_spec, as PathFinder has."""
    finders = sys.meta_path
    for other in finders[finders.index(finder) + 1 :]:
        if hasattr(other, 'find_spec'):
            yield other  # type: ignore[misc]


def _is_ours(rclpy: 'ModuleSpec') -> bool:
    """Return True if an rclpy is goalwire's: it lies in an overlay, or PyInstaller packed it with goalwire.

    The overlay may be that of another installed goalwire, whose folder comes first in sys.path.
    """
    if rclpy.origin is not None and (rclpy.origin.startswith(OVERLAY) or _is_in_an_overlay(rclpy.origin)):
        return True
    frozen = getattr(sys, 'frozen', False)
    return frozen and _regular('rclpy._reexports', list(rclpy.submodule_search_locations or ())) is not None


def _is_in_an_overlay(origin: str) -> bool:
    """Return True if a file is the module rclpy in an overlay, be it of this goalwire or of another one."""
    overlay = os.path.dirname(os.path.dirname(origin))
    goalwire = os.path.dirname(overlay)
    return (
        os.path.basename(overlay) == 'overlay'
        and os.path.basename(goalwire) == 'goalwire'
        and os.path.isfile(os.path.join(goalwire, 'idl', 'hook.py'))
    )


def _is_regular(spec: 'ModuleSpec | None') -> bool:
    return spec is not None and spec.loader is not None


def _not_ours(fullname: str, found: 'ModuleSpec') -> 'ModuleSpec | None':
    """Find another module of the same name outside the overlay in sys.path; that takes precedence."""
    if found.origin is None or not found.origin.startswith(OVERLAY):
        return None
    return _regular(fullname, [entry for entry in sys.path if entry != OVERLAY])


def _regular(fullname: str, path: list[str]) -> 'ModuleSpec | None':
    spec = PathFinder.find_spec(fullname, path)
    return spec if spec is not None and spec.loader is not None else None


def _wants_interfaces(name: str) -> bool:
    """Return True if a package is worth a walk through folders: libraries try many imports that may fail.

    It is if its name ends like interface packages' names, if its msg, srv or action is imported, or if no
    import statement asks.
    """
    if name.endswith(TELLING_ENDINGS) or not _asked_by_import_statement():
        return True
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_filename in _IMPORTERS:
        if frame.f_code.co_name == '_find_and_load_unlocked':  # importing `name`, or `name.msg` around it
            _, _, rest = frame.f_locals['name'].partition('.')
            if rest.partition('.')[0] in KINDS:
                return True
        frame = frame.f_back
    return frame is not None and not set(KINDS).isdisjoint(frame.f_code.co_names)  # from name import msg


def _asked_by_import_statement() -> bool:
    """Return True if an import statement asks; importlib.util.find_spec expects None, not an error."""
    frame = sys._getframe(1)  # importing inspect would take 10 ms
    while frame.f_back is not None and frame.f_code.co_filename == __file__:
        frame = frame.f_back  # skip this file's frames; then comes that of _find_spec
    caller = frame.f_back
    return caller is not None and caller.f_code.co_name == '_find_and_load_unlocked'
