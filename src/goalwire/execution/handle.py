"""Handles, as programs of rclpy use them: `with node.get_clock().handle, subscription.handle: …`."""

from __future__ import annotations

from types import TracebackType
from typing import Self, TypeVar, cast

from goalwire.errors import InvalidHandle

T = TypeVar('T')


class Handle:
    """An entity seen as its handle: a block that holds it, and whatever else the entity has.

    There is no C layer beneath. The block of the entity itself ends with its destruction, so this is another
    object.
    """

    __slots__ = ('ros_entity',)

    def __init__(self, entity: object) -> None:
        self.ros_entity = entity

    @property  # type: ignore[misc]
    def __class__(self) -> type:
        """The class of the entity: the handle passes for its entity."""
        return type(self.ros_entity)

    def __getattr__(self, name: str) -> object:
        return getattr(self.ros_entity, name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Handle) and other.ros_entity is self.ros_entity

    def __hash__(self) -> int:
        return object.__hash__(self.ros_entity)

    def __enter__(self) -> Self:
        """Raises InvalidHandle if the entity is destroyed."""
        if getattr(self.ros_entity, 'destroyed', False):
            raise InvalidHandle
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Let go of it; it lives on."""


def handle_of(entity: T) -> T:
    """Return the handle of `entity`, which has all of its attributes."""
    return cast('T', Handle(entity))


def entity_of(handle: T) -> T:
    """Return the entity that a handle is of; anything else as it is."""
    return cast('T', handle.ros_entity) if isinstance(handle, Handle) else handle
