"""As many robots as an argument says, made by a function that sees the arguments."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, OpaqueFunction, SetLaunchConfiguration
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution, TextSubstitution
from launch_ros.actions import Node, PushRosNamespace
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare


def robots(context, *args, **kwargs):
    count = int(LaunchConfiguration('count').perform(context))
    groups = []
    for index in range(count):
        name = f'robot_{index}'
        groups.append(
            GroupAction(
                [
                    PushRosNamespace(name),
                    SetLaunchConfiguration('robot_name', name),
                    Node(
                        package='demo_robot',
                        executable='driver',
                        name=[TextSubstitution(text='driver_'), str(index)],
                        parameters=[
                            {
                                'robot_description': ParameterValue(Command(['echo ', name]), value_type=str),
                                'id': index,
                                'text': '5',
                                'number': [LaunchConfiguration('count'), '0'],
                            },
                            ParameterFile(
                                PathJoinSubstitution(
                                    [FindPackageShare('demo_robot'), 'config', 'templated.yaml']
                                ),
                                allow_substs=True,
                            ),
                        ],
                    ),
                ]
            )
        )
    return groups


def generate_launch_description():
    return LaunchDescription(
        [DeclareLaunchArgument('count', default_value='2'), OpaqueFunction(function=robots)]
    )
