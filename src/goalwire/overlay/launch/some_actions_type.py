"""launch.some_actions_type."""

from goalwire.launching.model import (
    SomeEntities as SomeActionsType,
)

__all__ = [
    'SomeActionsType',
]
