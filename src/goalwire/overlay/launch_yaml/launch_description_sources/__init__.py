"""launch_yaml.launch_description_sources: loads launch files in YAML."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.sources import YAMLLaunchDescriptionSource

__all__ = ['YAMLLaunchDescriptionSource']

add_modules(__name__)
