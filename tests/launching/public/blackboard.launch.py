import os

from launch import LaunchDescription
from launch.actions import OpaqueFunction, TimerAction
from launch_ros.actions import Node, SetParameter


def start(context):
    config = os.path.join(os.path.dirname(__file__), 'blackboard.yaml')
    return [
        Node(
            package='demo_nodes_cpp',
            executable='parameter_blackboard',
            name='board',
            parameters=[config, {'port': 7}],
        )
    ]


def generate_launch_description():
    return LaunchDescription(
        [
            SetParameter('speed', 0.5),
            OpaqueFunction(function=start),
            TimerAction(
                period=0.1, actions=[Node(package='demo_nodes_py', executable='talker', output='screen')]
            ),
        ]
    )
