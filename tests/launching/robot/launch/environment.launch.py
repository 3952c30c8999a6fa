"""Environment variables, scopes, folders and prefixes."""

from launch import LaunchDescription
from launch.actions import (
    AppendEnvironmentVariable,
    ExecuteProcess,
    GroupAction,
    SetEnvironmentVariable,
    UnsetEnvironmentVariable,
)
from launch.substitutions import EnvironmentVariable, PathJoinSubstitution, ThisLaunchFileDir
from launch_ros.substitutions import ExecutableInPackage


def generate_launch_description():
    program = ExecutableInPackage(package='demo_robot', executable='plain')
    return LaunchDescription(
        [
            SetEnvironmentVariable('DEMO_MODE', 'outer'),
            GroupAction(
                [
                    SetEnvironmentVariable(name='DEMO_MODE', value='inner'),
                    AppendEnvironmentVariable('DEMO_PATH', '/one'),
                    AppendEnvironmentVariable('DEMO_PATH', '/zero', prepend=True),
                    ExecuteProcess(cmd=[program, 'inner'], additional_env={'DEMO_MORE': '1'}),
                ]
            ),
            ExecuteProcess(
                cmd=[program, EnvironmentVariable('DEMO_NOT_THERE', default_value='fallback')],
                cwd=PathJoinSubstitution([ThisLaunchFileDir(), '..', 'config']),
                prefix='env DEMO_PREFIX=yes',
                name='outer',
                emulate_tty=True,
                output='screen',
            ),
            UnsetEnvironmentVariable('DEMO_MODE'),
            ExecuteProcess(cmd=[program, 'last']),
        ]
    )
