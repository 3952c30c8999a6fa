import os

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    urdf = os.path.join(os.path.dirname(__file__), 'arm.urdf')
    with open(urdf) as file:
        description = file.read()
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'use_sim_time', default_value='false', description='Use simulation clock if true'
            ),
            Node(
                package='robot_state_publisher',
                executable='robot_state_publisher',
                name='robot_state_publisher',
                output='screen',
                parameters=[
                    {'use_sim_time': LaunchConfiguration('use_sim_time'), 'robot_description': description}
                ],
            ),
            Node(package='joint_state_publisher', executable='joint_state_publisher', output='screen'),
            Node(
                package='tf2_ros', executable='tf2_echo', arguments=['base', 'forearm', '20'], output='screen'
            ),
        ]
    )
