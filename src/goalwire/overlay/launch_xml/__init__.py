"""launch_xml: reads launch files in XML."""

import goalwire.launching.catalog  # noqa: F401 - it imports what launch files may name
from goalwire.launching.frontend import (
    Entity,
)
from goalwire.launching.frontend import (
    XMLParser as Parser,
)
from launch_xml import launch_description_sources

__all__ = [
    'Entity',
    'Parser',
    'launch_description_sources',
]
