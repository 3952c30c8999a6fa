"""launch.some_substitutions_type: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    SomeSubstitutions as SomeSubstitutionsType,
)
from goalwire.launching.utilities import (
    SomeSubstitutionsType_types_tuple,
)

__all__ = [
    'SomeSubstitutionsType',
    'SomeSubstitutionsType_types_tuple',
]
