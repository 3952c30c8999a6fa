"""launch_xml.entity."""

from goalwire.launching.frontend import Entity

__all__ = ['Entity']
