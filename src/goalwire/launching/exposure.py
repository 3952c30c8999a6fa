"""Two tables: the names of actions and those of substitutions in XML and YAML launch files.

Each class adds itself by a decorator; `catalog.py` imports all of goalwire's classes. Other packages add
classes by entry points of the group `launch.frontend.launch_extension`, which are loaded at the first unknown
name.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from importlib.metadata import entry_points
from typing import Any, TypeVar

from goalwire.errors import LaunchError
from goalwire.launching.errors import as_sentence
from goalwire.launching.model import Action, SomeSubstitutions, Substitution

_Class = TypeVar('_Class')
_actions: dict[str, Callable[[Any, Any], tuple[Any, dict[str, Any]]]] = {}
_substitutions: dict[str, Callable[[Sequence[SomeSubstitutions]], tuple[Any, dict[str, Any]]]] = {}
_loaded: set[str] = set()


def expose_action(*names: str) -> Callable[[_Class], _Class]:
    """Return a decorator that gives tags of these names an action: a class with `parse`, or a function."""
    return _expose_in(_actions, names)


def expose_substitution(*names: str) -> Callable[[_Class], _Class]:
    """Return a decorator that gives $(name …) a substitution: a class with `parse`, or a function."""
    return _expose_in(_substitutions, names)


def _expose_in(table: dict[str, Any], names: tuple[str, ...]) -> Callable[[_Class], _Class]:
    def expose(exposed: _Class) -> _Class:
        for name in names:
            table[name] = getattr(exposed, 'parse', exposed)
        return exposed

    return expose


def load_extensions() -> None:
    """Import other packages' extensions for launch files, each once in a process."""
    for point in entry_points(group='launch.frontend.launch_extension'):
        if point.name in _loaded:
            continue
        _loaded.add(point.name)
        try:
            point.load()
        except Exception as error:
            from goalwire.launching.output import get_logger

            get_logger('launch').warning(
                f'the launch extension {point.name} failed to load: {as_sentence(error)}'
            )


def list_exposed_actions() -> set[str]:
    """Return the names of all tags that actions have in XML and YAML."""
    return set(_actions)


def list_exposed_substitutions() -> set[str]:
    """Return the names that all substitutions have in XML and YAML."""
    return set(_substitutions)


def instantiate_action(entity: Any, parser: Any) -> Action:
    """Return the action of a tag. Raises LaunchError for an unknown tag, naming similar tags."""
    made, arguments = _parse(_actions, entity.type_name, 'tag')(entity, parser)
    entity.assert_entity_completely_parsed()
    action = made(**arguments)
    if not isinstance(action, Action):
        raise LaunchError(f'<{entity.type_name}> gives {type(action).__name__}, which is not an action')
    return action


def instantiate_substitution(name: str, data: Sequence[SomeSubstitutions] = ()) -> Substitution:
    """Return the substitution for $(name data…). Raises LaunchError for an unknown name."""
    made, arguments = _parse(_substitutions, name, 'substitution')(data)
    positional = arguments.pop('args', ())
    substitution = made(*positional, **arguments)
    if not isinstance(substitution, Substitution):
        raise LaunchError(f'$({name}) gives {type(substitution).__name__}, which is not a substitution')
    return substitution


def _parse(table: dict[str, Any], name: str, what: str) -> Callable[..., tuple[Any, dict[str, Any]]]:
    if name not in table:
        load_extensions()
    with contextlib.suppress(KeyError):
        found: Callable[..., tuple[Any, dict[str, Any]]] = table[name]
        return found
    from difflib import get_close_matches

    near = get_close_matches(name, table, n=3)
    hint = f'; did you mean {" or ".join(near)}?' if near else f'; known are {", ".join(sorted(table))}'
    raise LaunchError(f'unknown {what} `{name}`{hint}')
