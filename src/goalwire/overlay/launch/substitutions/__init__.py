"""launch.substitutions: texts that are found out when the launch runs."""

from goalwire.launching import substitutions as _substitutions
from goalwire.launching.aliases import add_modules
from goalwire.launching.substitutions import *  # noqa: F403 - what it exports is what ROS 2's does

__all__ = _substitutions.__all__

add_modules(__name__)
