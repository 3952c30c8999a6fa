"""launch_yaml: reads launch files in YAML."""

import goalwire.launching.catalog  # noqa: F401 - it imports what launch files may name
from goalwire.launching.frontend import (
    Entity,
)
from goalwire.launching.frontend import (
    YAMLParser as Parser,
)
from launch_yaml import launch_description_sources

__all__ = [
    'Entity',
    'Parser',
    'launch_description_sources',
]
