"""One thing after the other, by event handlers; the end of the last ends the launch."""

from launch import LaunchDescription
from launch.actions import (
    EmitEvent,
    ExecuteProcess,
    LogInfo,
    RegisterEventHandler,
    TimerAction,
)
from launch.event_handlers import OnExecutionComplete, OnProcessExit, OnProcessIO, OnProcessStart, OnShutdown
from launch.events import Shutdown
from launch.substitutions import FindExecutable, LocalSubstitution
from launch_ros.actions import Node


def generate_launch_description():
    first = Node(package='demo_robot', executable='short', name='calibrate')
    second = Node(package='demo_robot', executable='spawner', name='spawner')
    third = ExecuteProcess(cmd=[[FindExecutable(name='sh'), ' -c "exit 5"']], shell=True, name='last')

    def on_output(event):
        if b'spawner is up' in event.text:
            return [LogInfo(msg='the spawner said so'), TimerAction(period=0.05, actions=[third])]
        return None

    def on_last(event, context):
        return [
            LogInfo(msg=f'{event.process_name} gave {event.returncode}'),
            EmitEvent(event=Shutdown(reason='done')),
        ]

    return LaunchDescription(
        [
            first,
            RegisterEventHandler(OnProcessStart(target_action=first, on_start=[LogInfo(msg='calibrating')])),
            RegisterEventHandler(
                OnProcessExit(target_action=first, on_exit=[LogInfo(msg='calibrated'), second])
            ),
            RegisterEventHandler(OnProcessIO(target_action=second, on_stdout=on_output)),
            RegisterEventHandler(OnProcessExit(target_action=third, on_exit=on_last)),
            RegisterEventHandler(
                OnExecutionComplete(target_action=first, on_completion=[LogInfo(msg='first completed')])
            ),
            RegisterEventHandler(
                OnShutdown(on_shutdown=[LogInfo(msg=['shutting down: ', LocalSubstitution('event.reason')])])
            ),
        ]
    )
