"""launch_yaml.entity: offers the names of ROS 2's module of this name."""

from goalwire.launching.frontend import Entity

__all__ = ['Entity']
