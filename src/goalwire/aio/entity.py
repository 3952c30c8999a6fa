"""The base of all entities of the asyncio API: a name, `close`, and messages made from keyword arguments."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self


class Entity:
    """The base class of entities. They end with their node, by `close()`, or at the end of a `with` block."""

    name: str
    """The fully-qualified name."""

    def close(self) -> None:
        """End the entity. Idempotent."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f'<goalwire.{type(self).__name__} {self.name}>'


def message_of(kind: type, given: object, fields: dict[str, object]) -> object:
    """Return the given message, or make one of fields.

    Raises TypeError if both are given, and for an unknown field: the class of a message would ignore it, as
    in ROS 2, and a robot would act on the default value.
    """
    if given is None:
        if fields and not fields.keys() <= _names_of(kind):
            raise _unknown(kind, fields)
        return kind(**fields)
    if fields:
        raise TypeError(f'give a {kind.__name__} or its fields ({", ".join(fields)}), not both')
    return given


@cache
def _names_of(kind: Any) -> frozenset[str]:
    return frozenset(kind.get_fields_and_field_types())


def _unknown(kind: Any, fields: dict[str, object]) -> TypeError:
    known = kind.get_fields_and_field_types()
    field = next(field for field in fields if field not in known)
    there = ', '.join(known) or 'no fields'
    return TypeError(f"{kind.__name__} has no field '{field}'; it has {there}")
