"""launch.descriptions: offers the names of ROS 2's module of this name."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.process import Executable

__all__ = [
    'Executable',
]

add_modules(__name__)
