"""A node that dies is started again, twice; one that must not die ends the launch."""

from launch import LaunchDescription
from launch.actions import Shutdown
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription(
        [
            Node(
                package='demo_robot',
                executable='faulty',
                name='faulty',
                respawn=True,
                respawn_delay=0.05,
                respawn_max_retries=2,
                on_exit=[],
            ),
            Node(package='demo_robot', executable='base', name='base', on_exit=Shutdown()),
            Node(package='demo_robot', executable='driver', name='driver'),
        ]
    )
