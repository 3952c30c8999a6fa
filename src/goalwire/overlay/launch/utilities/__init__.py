"""launch.utilities: helpers for actions and substitutions of one's own."""

from goalwire.launching.model import (
    entity_list as normalize_to_list_of_entities,
)
from goalwire.launching.utilities import (
    ensure_argument_type,
    is_a,
    is_a_subclass,
)
from goalwire.launching.values import (
    is_substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

__all__ = [
    'ensure_argument_type',
    'is_a',
    'is_a_subclass',
    'is_substitution',
    'normalize_to_list_of_entities',
    'normalize_to_list_of_substitutions',
    'perform_substitutions',
]
