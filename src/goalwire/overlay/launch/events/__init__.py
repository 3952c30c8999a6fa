"""launch.events: the events of a launch, which event handlers react to."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.events import (
    IncludeLaunchDescription,
    Shutdown,
    TimerEvent,
    matches_action,
    matches_executable,
    matches_name,
    matches_pid,
)
from goalwire.launching.model import ExecutionComplete
from launch.events import process

__all__ = [
    'ExecutionComplete',
    'IncludeLaunchDescription',
    'Shutdown',
    'TimerEvent',
    'matches_action',
    'matches_executable',
    'matches_name',
    'matches_pid',
    'process',
]

add_modules(__name__, {'matches_action': 'matchers', 'process': 'process'})
