"""launch.frontend: defines new tags and substitutions for XML and YAML."""

from goalwire.errors import InvalidFrontendLaunchFileError
from goalwire.launching.exposure import (
    expose_action,
    expose_substitution,
)
from goalwire.launching.frontend import (
    Entity,
    Parser,
)
from goalwire.launching.notation import (
    parse_if_substitutions,
    parse_substitution,
)

__all__ = [
    'Entity',
    'InvalidFrontendLaunchFileError',
    'Parser',
    'expose_action',
    'expose_substitution',
    'parse_if_substitutions',
    'parse_substitution',
]
