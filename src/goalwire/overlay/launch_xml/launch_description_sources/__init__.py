"""launch_xml.launch_description_sources: loads launch files in XML."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.sources import XMLLaunchDescriptionSource

__all__ = ['XMLLaunchDescriptionSource']

add_modules(__name__)
