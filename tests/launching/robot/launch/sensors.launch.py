"""Sensors, as a part of the bring-up."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument('camera', default_value='false', description='Start the camera'),
            DeclareLaunchArgument('lidar_port', description='Serial port of the lidar'),
            Node(
                package='demo_robot',
                executable='lidar',
                name='lidar',
                namespace='sensors',
                parameters=[
                    {'port': LaunchConfiguration('lidar_port'), 'angles': [-1.5, 1.5], 'filter': {'on': True}}
                ],
            ),
            Node(
                package='demo_robot',
                executable='camera',
                name='camera',
                namespace='/cameras',
                condition=IfCondition(LaunchConfiguration('camera')),
            ),
        ]
    )
