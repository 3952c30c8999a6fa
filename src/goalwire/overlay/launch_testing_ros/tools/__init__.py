"""launch_testing_ros.tools: filters for the output of rmw implementations."""

from launch_testing_ros.tools.output import basic_output_filter

__all__ = ['basic_output_filter']
