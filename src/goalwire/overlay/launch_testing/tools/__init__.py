"""launch_testing.tools: compares output with expected output, and starts processes from a test."""

from launch_testing.tools.output import basic_output_filter, expect_output, expected_output_from_file
from launch_testing.tools.process import ProcessProxy, launch_process

__all__ = [
    'ProcessProxy',
    'basic_output_filter',
    'expect_output',
    'expected_output_from_file',
    'launch_process',
]
