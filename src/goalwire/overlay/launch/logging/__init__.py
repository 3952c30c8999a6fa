"""launch.logging: the loggers of a launch, which write to the screen and to log files."""

from goalwire.launching.output import (
    LaunchConfig,
    get_logger,
    get_output_loggers,
    launch_config,
    log_launch_config,
    reset,
)
from launch.logging import handlers

__all__ = [
    'LaunchConfig',
    'get_logger',
    'get_output_loggers',
    'handlers',
    'launch_config',
    'log_launch_config',
    'reset',
]
