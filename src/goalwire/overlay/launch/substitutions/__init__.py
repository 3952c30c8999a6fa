"""launch.substitutions: expressions that are evaluated to texts while the launch runs."""

from goalwire.launching import substitutions as _substitutions
from goalwire.launching.aliases import add_modules
from goalwire.launching.substitutions import *  # noqa: F403 - ROS 2's exports the same names

__all__ = _substitutions.__all__

add_modules(__name__)
