"""launch_xml.parser: the names of ROS 2's module."""

from goalwire.launching.frontend import XMLParser as Parser

__all__ = ['Parser']
