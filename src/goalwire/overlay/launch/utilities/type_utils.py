"""launch.utilities.type_utils: values of substitutions by type."""

from goalwire.launching.values import (
    coerce_to_type,
    is_substitution,
    normalize_typed_substitution,
    perform_typed_substitution,
)

__all__ = [
    'coerce_to_type',
    'is_substitution',
    'normalize_typed_substitution',
    'perform_typed_substitution',
]
