"""Two simulators, each in a namespace of its own."""

from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription(
        [
            Node(package='turtlesim', executable='turtlesim_node', namespace=namespace)
            for namespace in ('turtlesim1', 'turtlesim2')
        ]
    )
