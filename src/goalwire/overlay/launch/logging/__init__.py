"""launch.logging: the places where a launch writes its lines."""

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
