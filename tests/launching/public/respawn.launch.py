import sys

from launch import LaunchDescription
from launch.actions import ExecuteProcess, RegisterEventHandler
from launch.event_handlers import OnProcessExit, OnProcessStart
from launch_ros.actions import Node


def generate_launch_description():
    first = ExecuteProcess(cmd=[sys.executable, '-c', 'print("spawned")'], output='screen')
    server = Node(package='examples_rclpy_minimal_service', executable='service', output='screen')
    client = Node(package='examples_rclpy_minimal_client', executable='client_async', output='screen')
    return LaunchDescription(
        [
            first,
            RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[server])),
            RegisterEventHandler(OnProcessStart(target_action=server, on_start=[client])),
        ]
    )
