"""launch_yaml: launch files in YAML."""

from goalwire.launching.frontend import (
    Entity,
)
from goalwire.launching.frontend import (
    YAMLParser as Parser,
)

__all__ = [
    'Entity',
    'Parser',
]
