"""launch.utilities.type_utils: converts the texts of substitutions to values of a given type."""

from goalwire.launching.value_types import (
    coerce_list,
    get_typed_value,
    is_instance_of,
    is_instance_of_valid_type,
    is_normalized_substitution,
    is_typing_list,
    is_valid_scalar_type,
)
from goalwire.launching.values import (
    coerce_to_type,
    is_substitution,
    normalize_typed_substitution,
    perform_typed_substitution,
)
from goalwire.launching.values import (
    scalar_type as extract_type,
)

__all__ = [
    'coerce_list',
    'coerce_to_type',
    'extract_type',
    'get_typed_value',
    'is_instance_of',
    'is_instance_of_valid_type',
    'is_normalized_substitution',
    'is_substitution',
    'is_typing_list',
    'is_valid_scalar_type',
    'normalize_typed_substitution',
    'perform_typed_substitution',
]
