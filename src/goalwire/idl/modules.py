"""The modules that the import hook makes for one interface package:

    std_msgs               a package without contents of its own
    std_msgs.msg           String, Header, … each built when first asked for (PEP 562)
    std_msgs.msg._string   String and Metaclass_String, where rosidl has them and pickle looks for them

Each type is read when it is asked for, so a malformed file fails only where its type is imported.
"""

import os
from functools import lru_cache
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType

from goalwire.idl import classes, registry, search_path, workspace
from goalwire.idl.model import ActionDefinition, MessageDefinition, ServiceDefinition, module_name
from goalwire.idl.search_path import InterfacePackage

TYPE_CHECKING = False  # typing would cost 5 ms, importlib.abc 14 ms
if TYPE_CHECKING:
    from importlib.abc import Loader
else:
    Loader = object


_SHOWN = 30  # types that a message lists


class PackageModule(ModuleType):
    """<package>: it has no names of its own, and says where a type is that was looked for in it."""

    def __getattr__(self, name: str) -> object:
        explained = None if name.startswith('_') else _explain_misplaced(self.__name__, name)
        raise AttributeError(
            f'module {self.__name__!r} has no attribute {name!r}{f": {explained}" if explained else ""}',
            name=name,
            obj=self,
        )


class KindModule(ModuleType):
    """<package>.msg, .srv or .action: its attributes are the types, and those derived from them."""

    def __getattr__(self, name: str) -> object:
        package, _, kind = self.__name__.partition('.')
        if name.startswith('__') and name != '__all__':  # Python asks for these, and no type has such a name
            raise _no_attribute(self, name)
        known = type_names(package, kind)
        if name == '__all__':
            return known
        if name in _by_module(tuple(known)):
            return import_module(f'{self.__name__}.{name}')
        if name in known:
            found = _build(f'{package}/{kind}/{name}')
        elif owner := next((own for own in known if name.startswith(f'{own}_')), None):
            found = getattr(import_module(f'{self.__name__}.{module_name(owner)}'), name)
        else:
            raise _no_attribute(self, name)
        setattr(self, name, found)
        return found

    def __dir__(self) -> list[str]:
        package, _, kind = self.__name__.partition('.')
        return sorted({*super().__dir__(), *type_names(package, kind), *_modules(package, kind)})


class TypeModule(ModuleType):
    """<package>.<kind>._<type>: the type of one file, the types derived from it, and their metaclasses."""

    def __getattr__(self, name: str) -> object:
        wanted = name.removeprefix('Metaclass_')
        if wanted not in self._names():
            raise _no_attribute(self, name)
        package, kind, _ = self.__name__.split('.')
        found = _build(f'{package}/{kind}/{wanted}') if wanted == name else type(getattr(self, wanted))
        setattr(self, name, found)
        return found

    def __dir__(self) -> list[str]:
        names = self._names()
        return sorted({*super().__dir__(), *names, *(f'Metaclass_{name}' for name in names)})

    def _names(self) -> list[str]:
        package, kind, own = self.__name__.split('.')
        defined = registry.definition(f'{package}/{kind}/{_modules(package, kind)[own]}')
        names = [defined.name]
        if isinstance(defined, ServiceDefinition | ActionDefinition):
            names += [message.name for message in defined.messages]
        if isinstance(defined, ActionDefinition):
            names += [defined.send_goal.name, defined.get_result.name]
        return names


class InterfaceLoader(Loader):
    """Makes the modules; they fill themselves as their names are asked for."""

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        kinds = {0: PackageModule, 1: KindModule, 2: TypeModule}
        return kinds[spec.name.count('.')](spec.name, f'Interfaces from {spec.origin}.')

    def exec_module(self, module: ModuleType) -> None:
        """Nothing to run: a package is empty, the others look things up."""


def package_spec(package: str, found: InterfacePackage | None) -> ModuleSpec:
    """The spec of a package that is there, or that register_definitions made known."""
    return _spec(package, found, is_package=True)


def inner_spec(fullname: str, found: InterfacePackage | None = None) -> ModuleSpec | None:
    """The spec of std_msgs.msg or std_msgs.msg._string, None for all else; `found` is where std_msgs is."""
    package, kind, *rest = fullname.split('.')
    found = found or search_path.imported_package(package, kind)
    if not rest:
        return _spec(fullname, found, is_package=True) if _names_in(found, package, kind) else None
    if len(rest) == 1 and rest[0] in _by_module(tuple(_names_in(found, package, kind))):
        return _spec(fullname, found, is_package=False)
    return None


def explain_unknown(fullname: str) -> str | None:
    """Return the text for an import of std_msgs.msg.Strng or std_msgs.srv; None if Python's will do."""
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
        return f'{package} has no {kind} types (its definitions are in {place}){more}'
    if rest[0] in known:  # `import std_msgs.msg.String`: the from-import asks the module itself
        return f'{fullname} is a class, not a module; write: from {package}.{kind} import {rest[0]}'
    close = get_close_matches(rest[0], known, n=3)
    some = ', '.join(known[:_SHOWN]) + (f' and {len(known) - _SHOWN} more' if len(known) > _SHOWN else '')
    hint = (f'did you mean {" or ".join(close)}?' if close else f'it has {some}') + more
    file = f'{kind}/{rest[0]}.{kind}'
    return f'cannot import name {rest[0]!r} from {package}.{kind}: there is no {file} in {place}; {hint}'


def _explain_misplaced(package: str, name: str) -> str | None:
    """Return the error text for std_msgs.String: where the type is. None if there is no such type."""
    from difflib import get_close_matches

    kinds = {type_: kind for kind in reversed(workspace.KINDS) for type_ in type_names(package, kind)}
    for type_ in get_close_matches(name, kinds, n=1, cutoff=0.8):
        return f'types are one level below; write: from {package}.{kinds[type_]} import {type_}'
    return None


def _explain_python(fullname: str, package: str) -> str | None:
    """Return the error text for a module that lies beside the interfaces, but not on Python's path."""
    place = folder_of(package)
    if place is None or not os.path.isfile(os.path.join(place, package, '__init__.py')):
        return None
    return (
        f'No module named {fullname!r}: {package} is known by its interfaces in {place}, but its Python '
        f"modules there are not on Python's path: pip install -e {place}, or add {place} to PYTHONPATH"
    )


def type_names(package: str, kind: str) -> list[str]:
    """The types that a package defines in <kind>/, by file or by register_definitions, sorted."""
    return _names_in(search_path.imported_package(package, kind), package, kind)


def _names_in(found: InterfacePackage | None, package: str, kind: str) -> list[str]:
    here = f'{kind}/'
    names = {name.removeprefix(here) for name in registry.registered_types(package) if name.startswith(here)}
    if found:
        names.update(workspace.definition_names(found.folder, kind))
    return sorted(names)


def _modules(package: str, kind: str) -> dict[str, str]:
    """'_string' -> 'String', for each type."""
    return _by_module(tuple(type_names(package, kind)))


@lru_cache(maxsize=256)
def _by_module(names: tuple[str, ...]) -> dict[str, str]:
    return {module_name(name): name for name in names}


def _spec(name: str, found: InterfacePackage | None, *, is_package: bool) -> ModuleSpec:
    """The spec of one module, which keeps where its package was found (see imported_package)."""
    origin = found.folder if found else 'register_definitions'
    return ModuleSpec(name, InterfaceLoader(), origin=origin, loader_state=found, is_package=is_package)


def folder_of(package: str, kind: str = 'msg') -> str | None:
    """Where a package's definitions are, or 'register_definitions'; None for a package without interfaces."""
    if found := search_path.imported_package(package, kind):
        return found.folder
    return 'register_definitions' if registry.registered_types(package) else None


def _build(full_name: str) -> type:
    defined = registry.definition(full_name)
    if isinstance(defined, MessageDefinition):
        return classes.message_class(full_name)
    if isinstance(defined, ServiceDefinition):
        return classes.service_class(full_name)
    return classes.action_class(full_name)


def _no_attribute(module: ModuleType, name: str) -> AttributeError:
    return AttributeError(f'module {module.__name__!r} has no attribute {name!r}', name=name, obj=module)
