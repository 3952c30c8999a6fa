"""launch.some_substitutions_type: the names of ROS 2's module."""

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
