"""launch_yaml.parser: offers the names of ROS 2's module of this name."""

from goalwire.launching.frontend import YAMLParser as Parser

__all__ = ['Parser']
