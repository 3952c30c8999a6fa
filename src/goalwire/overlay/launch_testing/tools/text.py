"""launch_testing.tools.text: the names of ROS 2's module."""

from launch_testing.matching import build_line_match, build_text_match, normalize_lineseps

__all__ = ['build_line_match', 'build_text_match', 'normalize_lineseps']
