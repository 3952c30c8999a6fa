"""launch_xml.entity: the names of ROS 2's module."""

from goalwire.launching.frontend import Entity

__all__ = ['Entity']
