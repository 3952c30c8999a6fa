"""launch.actions: the actions that launch files consist of."""

from goalwire.launching.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ForEach,
    ForLoop,
    Log,
    LogInfo,
    OpaqueCoroutine,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
    TimerAction,
    UnregisterEventHandler,
)
from goalwire.launching.aliases import add_modules
from goalwire.launching.execute_process import ExecuteProcess
from goalwire.launching.process import ExecuteLocal
from goalwire.launching.scopes import (
    AppendEnvironmentVariable,
    GroupAction,
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    UnsetEnvironmentVariable,
    UnsetLaunchConfiguration,
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
