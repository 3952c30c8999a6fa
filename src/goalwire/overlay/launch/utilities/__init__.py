"""launch.utilities: helpers for programs that define new actions and substitutions."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.model import (
    entity_list as normalize_to_list_of_entities,
)
from goalwire.launching.signals import (
    AsyncSafeSignalManager,
)
from goalwire.launching.utilities import (
    ensure_argument_type,
    is_a,
    is_a_subclass,
    isclassinstance,
    visit_all_entities_and_collect_futures,
)
from goalwire.launching.values import (
    is_substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

__all__ = [
    'AsyncSafeSignalManager',
    'ensure_argument_type',
    'is_a',
    'is_a_subclass',
    'is_substitution',
    'isclassinstance',
    'normalize_to_list_of_entities',
    'normalize_to_list_of_substitutions',
    'perform_substitutions',
    'visit_all_entities_and_collect_futures',
]

add_modules(
    __name__,
    {
        'AsyncSafeSignalManager': 'signal_management',
        'ensure_argument_type': 'ensure_argument_type_impl',
        'is_a': 'class_tools_impl',
        'is_a_subclass': 'class_tools_impl',
        'isclassinstance': 'class_tools_impl',
        'is_substitution': 'substitutions_impl',
        'normalize_to_list_of_entities': 'normalize_to_list_of_entities_impl',
        'normalize_to_list_of_substitutions': 'normalize_to_list_of_substitutions_impl',
        'perform_substitutions': 'perform_substitutions_impl',
        'visit_all_entities_and_collect_futures': 'visit_all_entities_and_collect_futures_impl',
    },
)
