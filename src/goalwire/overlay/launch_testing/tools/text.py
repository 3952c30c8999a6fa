"""launch_testing.tools.text: offers the names of ROS 2's module of this name."""

from launch_testing.matching import build_line_match, build_text_match, normalize_lineseps

__all__ = ['build_line_match', 'build_text_match', 'normalize_lineseps']
