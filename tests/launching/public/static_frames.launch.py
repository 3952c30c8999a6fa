from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription(
        [
            Node(
                package='tf2_ros',
                executable='static_transform_publisher',
                arguments=['--x', '1', '--frame-id', 'world', '--child-frame-id', 'base'],
            ),
            Node(
                package='tf2_ros', executable='tf2_echo', arguments=['world', 'base', '20'], output='screen'
            ),
        ]
    )
