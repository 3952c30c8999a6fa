"""Small helpers that other packages' actions and substitutions import from launch.utilities."""

from __future__ import annotations

import collections.abc
from asyncio import Future
from collections.abc import Iterable
from typing import Any

from goalwire.launching.model import LaunchContext, LaunchDescriptionEntity, Substitution, visit_tree

SomeSubstitutionsType_types_tuple = (str, Substitution, collections.abc.Iterable)
"""The types that SomeSubstitutionsType stands for, as a tuple for isinstance()."""
SomeEntitiesType_types_tuple = (LaunchDescriptionEntity, collections.abc.Iterable)
"""The types that SomeEntitiesType stands for, as a tuple for isinstance()."""


def ensure_argument_type(
    argument: object, types: type | Iterable[type], argument_name: str, caller: str | None = None
) -> None:
    """Raise TypeError if an argument is not of one of these types."""
    allowed = (types,) if isinstance(types, type) else tuple(types)
    if not isinstance(argument, allowed):
        names = ', '.join(item.__name__ for item in allowed)
        where = f' of {caller}' if caller else ''
        raise TypeError(f"argument '{argument_name}'{where} is {type(argument).__name__}, expected {names}")


def is_a(obj: Any, entity_type: type) -> bool:
    """Return whether an object is an instance of a type."""
    return isinstance(obj, entity_type)


def is_a_subclass(obj: Any, entity_type: type) -> bool:
    """Return whether an object is an instance of a type, or is a class derived from the type."""
    return isinstance(obj, entity_type) or (isinstance(obj, type) and issubclass(obj, entity_type))


def isclassinstance(obj: object) -> bool:
    """Return whether an object is an instance, and not itself a class."""
    return not isinstance(obj, type)


def visit_all_entities_and_collect_futures(
    entity: LaunchDescriptionEntity, context: LaunchContext
) -> list[tuple[LaunchDescriptionEntity, Future[Any]]]:
    """Visit an entity and its sub-entities, depth first; return the entities to wait for, each with
    its future.
    """
    return list(visit_tree(entity, context))
