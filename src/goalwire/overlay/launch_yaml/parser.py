"""launch_yaml.parser: the names of ROS 2's module."""

from goalwire.launching.frontend import YAMLParser as Parser

__all__ = ['Parser']
