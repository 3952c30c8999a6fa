"""launch_testing: runs tests of programs that a launch description starts.

The names and rules are those of ROS 2's package of this name: https://github.com/ros2/launch
"""

from launch_testing import actions, asserts, event_handlers, markers, tools, util
from launch_testing.decorator import parametrize, post_shutdown_test, ready_to_test_action_timeout
from launch_testing.io_handler import ActiveIoHandler, IoHandler
from launch_testing.proc_info_handler import ActiveProcInfoHandler, ProcInfoHandler
from launch_testing.ready_aggregator import ReadyAggregator

__all__ = [
    'ActiveIoHandler',
    'ActiveProcInfoHandler',
    'IoHandler',
    'ProcInfoHandler',
    'ReadyAggregator',
    'actions',
    'asserts',
    'event_handlers',
    'markers',
    'parametrize',
    'post_shutdown_test',
    'ready_to_test_action_timeout',
    'tools',
    'util',
]
