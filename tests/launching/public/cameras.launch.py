from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription(
        [
            Node(
                package='image_tools',
                executable='cam2image',
                parameters=[{'burger_mode': True}],
                output='screen',
            ),
            Node(package='image_tools', executable='showimage', output='screen'),
        ]
    )
