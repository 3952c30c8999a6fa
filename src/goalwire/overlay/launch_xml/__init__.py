"""launch_xml: launch files in XML."""

from goalwire.launching.frontend import (
    Entity,
)
from goalwire.launching.frontend import (
    XMLParser as Parser,
)

__all__ = [
    'Entity',
    'Parser',
]
