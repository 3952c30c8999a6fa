"""The modules that the import hook makes for one interface package:

    std_msgs               a package without contents of its own
    std_msgs.msg           String, Header, … each built when first asked for (PEP 562)
    std_msgs.msg._string   String and Metaclass_String, where rosidl has them and pickle looks for them

Each type is read when it is asked for, so a malformed file fails only where its type is imported.
"""

import os
import sys
from functools import lru_cache, partial
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType

from goalwire.errors import InterfaceError
from goalwire.idl import classes, registry, search_path, workspace
from goalwire.idl.model import ActionDefinition, MessageDefinition, ServiceDefinition, module_name
from goalwire.idl.search_path import InterfacePackage
from goalwire.tracebacks import hide_own_frames

TYPE_CHECKING = False  # importing typing would take 5 ms, importlib.abc 14 ms
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from importlib.abc import Loader
    from pathlib import Path
else:
    Loader = object


REGISTERED = 'register_definitions'
_SHOWN = 30  # types that an error text lists at most


class InterfaceLoader(Loader):
    """Makes the modules of an interface package; a module makes a class when the class's name is first read.

    The modules are of the plain module type: jedi does not accept a subclass.
    """

    def __init__(self, folder: str | None, stubs: str | None) -> None:
        self._folder = folder
        self._stubs = stubs

    def create_module(self, spec: ModuleSpec) -> None:
        """Return None: Python then creates an ordinary module."""

    def exec_module(self, module: ModuleType) -> None:
        """Run nothing: a package is empty, other modules find names on demand (PEP 562)."""
        find, names = _CONTENTS[module.__name__.count('.')]
        module.__doc__ = f'Interfaces from {self._folder or REGISTERED}.'
        module.__dict__['__getattr__'] = partial(find, module)
        if names is not None:
            module.__dict__['__dir__'] = partial(names, module)

    def is_package(self, _fullname: str) -> bool:
        """Return True for an interface package and its msg, srv and action, not for modules of one type."""
        return self._stubs is not None

    def get_filename(self, fullname: str) -> str:
        """Return the file that a package would have, beside its stubs. Raises ImportError without stubs."""
        if not self._stubs:
            raise ImportError('it is made of definitions, and has no file', name=fullname)
        return os.path.join(self._stubs, '__init__.py')

    def get_source(self, _fullname: str) -> str:
        """Return an empty source, for jedi."""
        return ''

    def get_resource_reader(self, _fullname: str) -> 'DefinitionFiles | None':
        """Let importlib.resources.files() return the folder of a package's definitions."""
        return DefinitionFiles(self._folder) if self._folder else None


class DefinitionFiles:
    """The definitions of a package, for importlib.resources."""

    def __init__(self, folder: str) -> None:
        self._folder = folder

    def files(self) -> 'Path':
        from pathlib import Path

        return Path(self._folder)


class InnerModules:
    """Finds the modules in a package or in its msg, srv or action, for tools that search its `__path__`."""

    def __init__(self, fullname: str, folder: str) -> None:
        self._fullname = fullname
        self._folder = folder

    def find_spec(self, fullname: str, _target: ModuleType | None = None) -> ModuleSpec | None:
        """Find `msg`, `srv` or `action` for jedi, which leaves out the package's name: a folder of stubs."""
        if '.' in self._fullname or fullname not in workspace.KINDS:
            return None
        spec = ModuleSpec(fullname, None, is_package=True)
        spec.submodule_search_locations = [os.path.join(self._folder, fullname)]
        return spec

    def iter_modules(self, prefix: str = '') -> 'Iterator[tuple[str, bool]]':
        """Yield the name of each inner module, and whether the module is a package."""
        package, _, kind = self._fullname.partition('.')
        if kind:
            yield from ((prefix + name, False) for name in _modules(package, kind))
        else:
            yield from ((prefix + each, True) for each in workspace.KINDS if type_names(package, each))


def _find_misplaced(module: ModuleType, name: str) -> object:
    """Raise AttributeError for a name in <package>; the text says where a type of that name is."""
    explained = None if name.startswith('_') else _explain_misplaced(module.__name__, name)
    raise AttributeError(
        f'module {module.__name__!r} has no attribute {name!r}{f": {explained}" if explained else ""}',
        name=name,
        obj=module,
    )


def _find_type(module: ModuleType, name: str) -> object:
    """Return a type, or a derived type, of <package>.msg, .srv or .action, and keep it as an attribute."""
    package, _, kind = module.__name__.partition('.')
    if name.startswith('__') and name != '__all__':  # only Python asks for such names
        raise _no_attribute(module, name)
    known = type_names(package, kind)
    if name == '__all__':
        return known
    if name in _by_module(tuple(known)):
        return import_module(f'{module.__name__}.{name}')
    if name in known:
        found: object = _build(f'{package}/{kind}/{name}')
    elif owner := next((own for own in known if name.startswith(f'{own}_')), None):
        found = getattr(import_module(f'{module.__name__}.{module_name(owner)}'), name)
    else:
        raise _no_attribute(module, name)
    setattr(module, name, found)
    return found


def _list_types(module: ModuleType) -> list[str]:
    package, _, kind = module.__name__.partition('.')
    return sorted({*vars(module), *type_names(package, kind), *_modules(package, kind)})


def _find_part(module: ModuleType, name: str) -> object:
    """Return an attribute of <package>.<kind>._<type>: its type, a derived type, or a metaclass of these."""
    wanted = name.removeprefix('Metaclass_')
    if name.startswith('__') or wanted not in _part_names(module):
        raise _no_attribute(module, name)
    package, kind, _ = module.__name__.split('.')
    found = _build(f'{package}/{kind}/{wanted}') if wanted == name else type(getattr(module, wanted))
    setattr(module, name, found)
    return found


def _list_parts(module: ModuleType) -> list[str]:
    names = _part_names(module)
    return sorted({*vars(module), *names, *(f'Metaclass_{name}' for name in names)})


def _part_names(module: ModuleType) -> list[str]:
    package, kind, own = module.__name__.split('.')
    defined = registry.definition(f'{package}/{kind}/{_modules(package, kind)[own]}')
    names = [defined.name]
    if isinstance(defined, ServiceDefinition | ActionDefinition):
        names += [message.name for message in defined.messages]
    if isinstance(defined, ActionDefinition):
        names += [defined.send_goal.name, defined.get_result.name]
    return names


_CONTENTS: 'tuple[tuple[Callable[..., object], Callable[..., list[str]] | None], ...]' = (
    (_find_misplaced, None),
    (_find_type, _list_types),
    (_find_part, _list_parts),
)
"""By a module's depth (dots in its name): the function that finds a name, and that which lists all names."""


def package_spec(package: str, found: InterfacePackage | None, stubs: str) -> ModuleSpec:
    """Return the spec of an interface package, found as files or registered by register_definitions.

    `stubs` is the folder of its type stubs, or '': editors look for stubs on the package's `__path__`.
    """
    return _spec(package, found, stubs)


def inner_spec(
    fullname: str, path: 'Sequence[str]', found: InterfacePackage | None = None
) -> ModuleSpec | None:
    """Return the spec of a module such as std_msgs.msg or std_msgs.msg._string; None for others.

    `path` is the `__path__` of the enclosing package; `found` is where the package, as std_msgs, was found.
    """
    package, kind, *rest = fullname.split('.')
    found = found or search_path.find_imported_package(package, kind)
    if not rest:
        stubs = os.path.join(path[0], kind) if path else ''
        return _spec(fullname, found, stubs) if _names_in(found, package, kind) else None
    if len(rest) == 1 and rest[0] in _by_module(tuple(_names_in(found, package, kind))):
        return _spec(fullname, found, None)
    return None


def explain_unknown(fullname: str) -> str | None:
    """Return the error text for an import such as std_msgs.msg.Strng; None if Python's text is enough."""
    from difflib import get_close_matches

    package, kind, *rest = fullname.split('.')
    if kind not in workspace.KINDS:
        misplaced = None if rest else _explain_misplaced(package, kind)
        if misplaced:
            return f'cannot import name {kind!r} from {package!r}: {misplaced}'
        return _explain_python(fullname, package)
    if len(rest) > 1 or fullname.rpartition('.')[2][0] == '_':
        return None
    place, known = folder_of(package, kind), type_names(package, kind)
    overridden = search_path.explain_overridden(package)
    more = f'; {overridden}' if overridden else ''
    if not known:
        elsewhere = [f'{package}.{other}' for other in workspace.KINDS if type_names(package, other)]
        hint = f'; it has some elsewhere: write from {" or ".join(elsewhere)} import …' if elsewhere else ''
        return f'{package} has no {kind} types (its definitions are in {place}){hint}{more}'
    if rest[0] in known:  # `import std_msgs.msg.String`; a from-import would not get here
        return f'{fullname} is a class, not a module; write: from {package}.{kind} import {rest[0]}'
    close = get_close_matches(rest[0], known, n=3)
    some = ', '.join(known[:_SHOWN]) + (f' and {len(known) - _SHOWN} more' if len(known) > _SHOWN else '')
    hint = (f'did you mean {" or ".join(close)}?' if close else f'it has {some}') + more
    file = f'{kind}/{rest[0]}.{kind}'
    if close and close[0].replace('_', '').lower() == rest[0].lower():
        return (
            f'cannot import name {rest[0]!r} from {package}.{kind}: '
            f'the name of a definition is in CamelCase; rename {kind}/{close[0]}.{kind} in {place} '
            f'to {rest[0]}.{kind}'
        )
    return f'cannot import name {rest[0]!r} from {package}.{kind}: there is no {file} in {place}; {hint}'


def _explain_misplaced(package: str, name: str) -> str | None:
    """Return the error text for a name like std_msgs.String: the type's place; None for unknown types."""
    from difflib import get_close_matches

    kinds = {type_: kind for kind in reversed(workspace.KINDS) for type_ in type_names(package, kind)}
    for type_ in get_close_matches(name, kinds, n=1, cutoff=0.8):
        return f'types are one level below; write: from {package}.{kinds[type_]} import {type_}'
    return None


def _explain_python(fullname: str, package: str) -> str | None:
    """Return the error text for a Python module beside the definitions, but not on Python's path."""
    place = folder_of(package)
    if place is None or not os.path.isfile(os.path.join(place, package, '__init__.py')):
        return None
    return (
        f'No module named {fullname!r}: {package} is known by its interfaces in {place}, but its Python '
        f"modules there are not on Python's path: pip install -e {place}, or add {place} to PYTHONPATH"
    )


def type_names(package: str, kind: str) -> list[str]:
    """Return the sorted type names of a package's <kind>, from files and from register_definitions."""
    return _names_in(search_path.find_imported_package(package, kind), package, kind)


def _names_in(found: InterfacePackage | None, package: str, kind: str) -> list[str]:
    here = f'{kind}/'
    names = {name.removeprefix(here) for name in registry.registered_types(package) if name.startswith(here)}
    if found:
        names.update(workspace.definition_names(found.folder, kind))
    return sorted(names)


def _modules(package: str, kind: str) -> dict[str, str]:
    """Map module names to types, such as '_string' to 'String'."""
    return _by_module(tuple(type_names(package, kind)))


@lru_cache(maxsize=256)
def _by_module(names: tuple[str, ...]) -> dict[str, str]:
    return {module_name(name): name for name in names}


def _spec(name: str, found: InterfacePackage | None, stubs: str | None) -> ModuleSpec:
    """Return the spec of one module; the spec keeps where the package was found (see imported_package).

    `stubs` is the folder of a package's stubs; None for a module that is not a package.
    """
    folder = found.folder if found else None
    loader = InterfaceLoader(folder, stubs)
    spec = ModuleSpec(
        name, loader, origin=folder or REGISTERED, loader_state=found, is_package=stubs is not None
    )
    if stubs:
        spec.submodule_search_locations = [stubs]
        sys.path_importer_cache[stubs] = InnerModules(name, stubs)
    return spec


def folder_of(package: str, kind: str = 'msg') -> str | None:
    """Return where a package's definitions are, or 'register_definitions'; None without interfaces."""
    if found := search_path.find_imported_package(package, kind):
        return found.folder
    return REGISTERED if registry.registered_types(package) else None


def _build(full_name: str) -> type:
    try:
        return _make(full_name)
    except InterfaceError:
        hide_own_frames()
        raise


def _make(full_name: str) -> type:
    defined = registry.definition(full_name)
    if isinstance(defined, MessageDefinition):
        return classes.message_class(full_name)
    if isinstance(defined, ServiceDefinition):
        return classes.service_class(full_name)
    return classes.action_class(full_name)


def _no_attribute(module: ModuleType, name: str) -> AttributeError:
    return AttributeError(f'module {module.__name__!r} has no attribute {name!r}', name=name, obj=module)
