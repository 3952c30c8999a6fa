"""launch.event_handlers: event handlers for actions, processes and the launch."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.event_handlers import (
    OnActionEventBase,
    OnExecutionComplete,
    OnIncludeLaunchDescription,
    OnShutdown,
)
from goalwire.launching.process_handlers import OnProcessExit, OnProcessIO, OnProcessStart

__all__ = [
    'OnActionEventBase',
    'OnExecutionComplete',
    'OnIncludeLaunchDescription',
    'OnProcessExit',
    'OnProcessIO',
    'OnProcessStart',
    'OnShutdown',
]

add_modules(__name__, {'OnProcessIO': 'on_process_io'})
