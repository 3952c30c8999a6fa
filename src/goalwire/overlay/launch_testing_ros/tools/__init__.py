"""launch_testing_ros.tools: filters of output that know rmw implementations."""

from launch_testing_ros.tools.output import basic_output_filter

__all__ = ['basic_output_filter']
