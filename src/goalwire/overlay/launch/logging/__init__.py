"""launch.logging: loggers of a launch, for the screen and log files."""

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
