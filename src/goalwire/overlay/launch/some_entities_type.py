"""launch.some_entities_type: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    SomeEntities as SomeEntitiesType,
)
from goalwire.launching.utilities import (
    SomeEntitiesType_types_tuple,
)

__all__ = [
    'SomeEntitiesType',
    'SomeEntitiesType_types_tuple',
]
