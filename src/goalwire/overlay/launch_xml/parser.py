"""launch_xml.parser: offers the names of ROS 2's module of this name."""

from goalwire.launching.frontend import XMLParser as Parser

__all__ = ['Parser']
