"""Handles, as programs of rclpy use them: `with node.get_clock().handle, subscription.handle: …`."""

from __future__ import annotations

from types import TracebackType
from typing import Self, TypeVar, cast

from goalwire.errors import InvalidHandle

T = TypeVar('T')


class Handle:
    """The handle of an entity, for `with entity.handle:`. It has all attributes of the entity.

    rclpy's handles are objects of its C layer; here there is no such layer. The handle is an object of its
    own, because `with entity:` destroys the entity at the end, and `with entity.handle:` does not.
    """

    __slots__ = ('ros_entity',)

    def __init__(self, entity: object) -> None:
        self.ros_entity = entity

    @property  # type: ignore[misc]
    def __class__(self) -> type:
        """The class of the entity, so that isinstance() takes the handle for its entity."""
        return type(self.ros_entity)

    @property
    def pointer(self) -> int:
        """The number of the entity in `get_ready_entities` of a wait set."""
        return id(self.ros_entity)

    def __getattr__(self, name: str) -> object:
        return getattr(self.ros_entity, name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Handle) and other.ros_entity is self.ros_entity

    def __hash__(self) -> int:
        return object.__hash__(self.ros_entity)

    def __enter__(self) -> Self:
        """Return the handle; raise InvalidHandle if the entity is destroyed."""
        if getattr(self.ros_entity, 'destroyed', False):
            raise InvalidHandle
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Do nothing: the entity lives on."""


def handle_of(entity: T) -> T:
    """Return the handle of `entity`, which has all of its attributes."""
    return cast('T', Handle(entity))


def entity_of(handle: T) -> T:
    """Return the entity of a handle; any other object is returned unchanged."""
    return cast('T', handle.ros_entity) if isinstance(handle, Handle) else handle
