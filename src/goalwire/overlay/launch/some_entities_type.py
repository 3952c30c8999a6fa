"""launch.some_entities_type."""

from goalwire.launching.model import (
    SomeEntities as SomeEntitiesType,
)

__all__ = [
    'SomeEntitiesType',
]
