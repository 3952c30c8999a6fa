"""launch.event_handlers: answers to events."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.event_handlers import (
    OnActionEventBase,
    OnExecutionComplete,
    OnIncludeLaunchDescription,
    OnProcessExit,
    OnProcessIO,
    OnProcessStart,
    OnShutdown,
)

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
