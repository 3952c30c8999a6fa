"""launch.actions: what a launch file does."""

from goalwire.launching.actions import (
    AppendEnvironmentVariable,
    DeclareLaunchArgument,
    EmitEvent,
    ForEach,
    ForLoop,
    GroupAction,
    Log,
    LogInfo,
    OpaqueCoroutine,
    OpaqueFunction,
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    RegisterEventHandler,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    Shutdown,
    TimerAction,
    UnregisterEventHandler,
    UnsetEnvironmentVariable,
    UnsetLaunchConfiguration,
)
from goalwire.launching.aliases import add_modules
from goalwire.launching.process import (
    ExecuteLocal,
    ExecuteProcess,
)
from goalwire.launching.sources import (
    IncludeLaunchDescription,
    ScopedIncludeLaunchDescription,
)

__all__ = [
    'AppendEnvironmentVariable',
    'DeclareLaunchArgument',
    'EmitEvent',
    'ExecuteLocal',
    'ExecuteProcess',
    'ForEach',
    'ForLoop',
    'GroupAction',
    'IncludeLaunchDescription',
    'Log',
    'LogInfo',
    'OpaqueCoroutine',
    'OpaqueFunction',
    'PopEnvironment',
    'PopLaunchConfigurations',
    'PushEnvironment',
    'PushLaunchConfigurations',
    'RegisterEventHandler',
    'ResetEnvironment',
    'ResetLaunchConfigurations',
    'ScopedIncludeLaunchDescription',
    'SetEnvironmentVariable',
    'SetLaunchConfiguration',
    'Shutdown',
    'TimerAction',
    'UnregisterEventHandler',
    'UnsetEnvironmentVariable',
    'UnsetLaunchConfiguration',
]

add_modules(__name__, {'Shutdown': 'shutdown_action', 'ForLoop': 'for_loop'})
