"""launch.substitutions: expressions that are evaluated to texts while the launch runs."""

from goalwire.launching import condition_substitutions as _conditions
from goalwire.launching import substitutions as _substitutions
from goalwire.launching.aliases import add_modules
from goalwire.launching.condition_substitutions import *  # noqa: F403 - ROS 2's exports the same names
from goalwire.launching.substitutions import *  # noqa: F403

__all__: list[str] = []
__all__ += _conditions.__all__
__all__ += _substitutions.__all__

add_modules(__name__)
