"""A node that ignores SIGINT, and one whose shell leaves a program behind."""

from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node
from launch_ros.substitutions import ExecutableInPackage


def generate_launch_description():
    return LaunchDescription(
        [
            Node(package='demo_robot', executable='stubborn', sigterm_timeout='0.3'),
            ExecuteProcess(
                cmd=[ExecutableInPackage(package='demo_robot', executable='stubborn'), ' left & exit 0'],
                shell=True,
                name='shell',
                sigterm_timeout='0.3',
            ),
            Node(package='demo_robot', executable='driver'),
        ]
    )
