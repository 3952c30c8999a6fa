"""launch: launch descriptions, and the LaunchService that carries them out."""

import goalwire.launching.catalog  # noqa: F401 - it imports what launch files may name
from goalwire.errors import InvalidLaunchFileError
from goalwire.launching.introspection import LaunchIntrospector
from goalwire.launching.model import (
    Action,
    Condition,
    Event,
    EventHandler,
    LaunchContext,
    LaunchDescription,
    LaunchDescriptionEntity,
    Substitution,
)
from goalwire.launching.model import SomeEntities as SomeActionsType
from goalwire.launching.model import SomeEntities as SomeEntitiesType
from goalwire.launching.model import SomeSubstitutions as SomeSubstitutionsType
from goalwire.launching.service import LaunchService
from goalwire.launching.sources import LaunchDescriptionSource
from goalwire.launching.utilities import SomeEntitiesType_types_tuple, SomeSubstitutionsType_types_tuple
from launch import (
    actions,
    conditions,
    descriptions,
    event_handlers,
    events,
    frontend,
    launch_description_sources,
    logging,
    substitutions,
    utilities,
)

__all__ = [
    'Action',
    'Condition',
    'Event',
    'EventHandler',
    'InvalidLaunchFileError',
    'LaunchContext',
    'LaunchDescription',
    'LaunchDescriptionEntity',
    'LaunchDescriptionSource',
    'LaunchIntrospector',
    'LaunchService',
    'SomeActionsType',
    'SomeEntitiesType',
    'SomeEntitiesType_types_tuple',
    'SomeSubstitutionsType',
    'SomeSubstitutionsType_types_tuple',
    'Substitution',
    'actions',
    'conditions',
    'descriptions',
    'event_handlers',
    'events',
    'frontend',
    'launch_description_sources',
    'logging',
    'substitutions',
    'utilities',
]
