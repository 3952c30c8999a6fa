from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription(
        [
            Node(package='action_tutorials_py', executable='fibonacci_action_server', output='screen'),
            Node(package='action_tutorials_py', executable='fibonacci_action_client', output='screen'),
        ]
    )
