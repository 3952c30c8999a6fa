"""launch_yaml: launch files in YAML."""

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
